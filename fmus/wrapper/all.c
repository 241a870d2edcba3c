/* The whole FMU as one translation unit, so that nothing but the fmi2 functions has external linkage.

   guid.h, model.h and model.c are generated; the rest knows no model. */
#include "guid.h"
#include "instance.h"
#include "model.c"

#include "messages.c"
#include "advance.c"

#include "lifecycle.c"
#include "values.c"
#include "step.c"
#include "states.c"
