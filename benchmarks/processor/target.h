/* What reset.c and loop.c share: semihosting as Arm documents it, and the stack's mark. */
#ifndef TARGET_H
#define TARGET_H

#include <stdint.h>

enum { SYS_OPEN = 0x01, SYS_WRITE = 0x05, SYS_READ = 0x06, SYS_EXIT = 0x18 };
enum { APPLICATION_EXIT = 0x20026, RUN_TIME_ERROR = 0x20023 };
#define UNTOUCHED 0xA5A5A5A5u

long host(long operation, const void *arguments);
uint32_t stack_used(void);

#endif
