/* What the hosts use of POSIX, on Windows. */
#include <windows.h>

#define RTLD_NOW 0
#define RTLD_LOCAL 0
#define dlopen(path, mode) ((void *)LoadLibraryA(path))
#define dlsym(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#define dlerror() "the library or a function of it was not found"
