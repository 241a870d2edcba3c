/* What a Windows library built without a compiler's own run-time library has to bring along. */
#include <stdarg.h>
#include <stddef.h>

#define STANDARD_SNPRINTF 2ull /* terminate always, return the length */

int __stdio_common_vsprintf(unsigned long long options, char *buffer, size_t size, const char *format, void *locale,
                            va_list arguments);

int _fltused; /* a mark by which the linker knows that floating point is used */

int vsnprintf(char *buffer, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(STANDARD_SNPRINTF, buffer, size, format, NULL, arguments);
}

int snprintf(char *buffer, size_t size, const char *format, ...)
{
    va_list arguments;
    int length;
    va_start(arguments, format);
    length = vsnprintf(buffer, size, format, arguments);
    va_end(arguments);
    return length;
}
