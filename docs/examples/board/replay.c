/* plant.h for a board in an emulator: a recorded flight, read from the host's file flight.bin by semihosting.

   A row has the inputs of a tick, and the outputs that the host's controller gave there. Prints
   "rows difference arena stack": the largest difference relative to the nominal values, and bytes. */
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

#include "plant.h"

#define PAINT UINT32_C(0x5ca1ab1e)

extern uint32_t __heap_end[], __stack[]; /* the linker's bounds of the stack, which grows downwards */

static const double NOMINAL[N_OUTPUTS] = NOMINALS;
static double row[N_INPUTS + N_OUTPUTS];
static double worst;
static long rows;
static int file = -1;

static void paint_the_stack(void)
{
    volatile uint32_t *here = __builtin_frame_address(0);
    for (volatile uint32_t *at = __heap_end; at < here - 64; at++) /* this call's own frame is left alone */
        *at = PAINT;
}

static size_t stack_used(void)
{
    uint32_t *at = __heap_end;
    while (at < __stack && *at == PAINT)
        at++;
    return (size_t)(__stack - at) * sizeof *at;
}

int measure(double u[N_INPUTS])
{
    if (file < 0) {
        file = open("flight.bin", O_RDONLY);
        paint_the_stack();
    }
    if (read(file, row, sizeof row) != (int)sizeof row)
        return 0;
    for (int i = 0; i < N_INPUTS; i++)
        u[i] = row[i];
    return 1;
}

void actuate(const double y[N_OUTPUTS])
{
    for (int i = 0; i < N_OUTPUTS; i++)
        worst = fmax(worst, fabs(y[i] - row[N_INPUTS + i]) / NOMINAL[i]);
    rows++;
}

int finish(size_t arena)
{
    size_t stack = stack_used();
    printf("%ld %.3g %u %u\n", rows, worst, (unsigned)arena, (unsigned)stack);
    return 0;
}
