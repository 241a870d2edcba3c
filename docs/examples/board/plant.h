/* What main.c asks of the board. */
#include <stddef.h>

#include "wiring.h"

/* Waits for the next tick and reads the inputs of the controller; 0 to end. */
int measure(double u[N_INPUTS]);

/* Passes the outputs on. */
void actuate(const double y[N_OUTPUTS]);

/* After the last tick; `arena` is how many bytes the controller took. What it returns is the program's exit status. */
int finish(size_t arena);
