"""A page that flies the closed loop in a browser: the FMUs as WebAssembly modules, and what the page knows of them."""
