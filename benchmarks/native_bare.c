/* The functions in an FMU's sources/model.c, called as its wrapper calls them and with nothing around them. */
#include "core.h"

#include "model.c"

double x0[LENGTH(NX)], u[LENGTH(NU)], p[LENGTH(NP)], y[LENGTH(NY)], k[LENGTH(NK)], c[LENGTH(NC)], h;
static int count;

/* Start values, prepared for steps of `step` seconds. */
void bare_begin(double step)
{
    for (int i = 0; i < NV; i++) {
        if (TABLE[i].role == INPUT)
            u[TABLE[i].place] = TABLE[i].start;
        if (TABLE[i].role == PARAMETER)
            p[TABLE[i].place] = TABLE[i].start;
    }
    count = (int)fmax(1, ceil(step / INTERNAL_STEP(p) - 1e-9));
    h = step / count;
    model_constants((const double *[]){p}, (double *[]){k});
    model_prepare((const double *[]){p, &h, k}, (double *[]){c});
    model_start((const double *[]){u, p}, (double *[]){x0});
}

/* `steps` communication steps from the start, with the inputs held. */
void bare_steps(int steps)
{
    double x[2][LENGTH(NX)], w[LENGTH(NW)], t = 0;
    const double *arg[] = {&t, &h, x0, u, p, k, c, w, &t};
    for (int i = 0, into = 0; i < steps; i++) {
        __asm__ volatile("" ::: "memory"); /* the compiler may not do for all steps at once what each does anew */
        model_hold((const double *[]){&h, u, p, k, c}, (double *[]){w});
        for (int j = 0; j < count - 1; j++, into = !into) {
            model_advance(arg, (double *[]){x[into], y});
            arg[2] = x[into];
        }
        model_finish(arg, (double *[]){x[into], y});
        arg[2] = x[into];
        into = !into;
    }
}
