/* Sine and cosine of the wrapper for every argument on stdin, in hexadecimal. */
#include <stdio.h>

#include "angles.h"

int main(void)
{
    double x;
    while (scanf("%la", &x) == 1)
        printf("%a %a\n", angle_sin(x), angle_cos(x));
    return 0;
}
