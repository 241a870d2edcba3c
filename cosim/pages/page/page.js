"use strict";
show(PAGE);
