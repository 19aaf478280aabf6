/* What a library needs beside the C runtime of Windows: MinGW has it in libraries that are compiled first. */

#define __CRT__NO_INLINE /* MinGW's headers define some of these in place, but not without optimisation */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>

/* Asked for by the linker wherever there are floating-point numbers. */
int _fltused = 1;

/* Called as the library is loaded and unloaded; there is nothing to do. */
int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void)library, (void)reason, (void)reserved;
    return 1;
}

/* What isnan and isfinite of <math.h> call. */
int __isnan(double value)
{
    return value != value;
}

int __fpclassify(double value)
{
    double size = value < 0 ? -value : value;
    if (value != value)
        return FP_NAN;
    if (size > DBL_MAX)
        return FP_INFINITE;
    return size == 0 ? FP_ZERO : size < DBL_MIN ? FP_SUBNORMAL : FP_NORMAL;
}

/* The one function by which the runtime prints into a buffer, and the option by which it does as C99 says
 * (Microsoft's <corecrt_stdio_config.h>). */
int __stdio_common_vsprintf(unsigned long long options, char *buffer, size_t size, const char *format,
                            void *locale, va_list arguments);
#define AS_C99_SAYS 2ULL

int vsnprintf(char *buffer, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(AS_C99_SAYS, buffer, size, format, NULL, arguments);
}

int snprintf(char *buffer, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(buffer, size, format, arguments);
    va_end(arguments);
    return length;
}
