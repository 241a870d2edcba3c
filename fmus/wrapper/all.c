/* The whole FMU as one translation unit, so that nothing but the functions of FMI has external linkage. A program that
   links several FMUs gives each names of its own: -DFMI2_FUNCTION_PREFIX=A_ -DFMI3_FUNCTION_PREFIX=A_.

   guid.h, model.h and model.c are generated; the rest knows no model. */
#include "guid.h"
#include "core.h"
#include "model.c"

#include "messages.c"
#include "advance.c"
#include "lifecycle.c"
#include "values.c"
#include "derivatives.c"
#include "step.c"
#include "exchange.c"
#include "states.c"

/* -DWITHOUT_FMI2 or -DWITHOUT_FMI3 leaves a door out. */
#ifndef WITHOUT_FMI2
#include "fmi2.c"
#include "fmi2_time.c"
#endif
#ifndef WITHOUT_FMI3
#include "fmi3.c"
#include "fmi3_time.c"
#include "fmi3_none.c"
#endif
