/* Functions of the wrapper for every argument on stdin, in hexadecimal. */
#include <stdio.h>

#include "mathematics.h"

int main(void)
{
    double x;
    while (scanf("%la", &x) == 1)
        printf("%a %a %a %a %a\n", own_exp(x), own_sin(x), own_cos(x), own_tan(x), own_asin(x));
    return 0;
}
