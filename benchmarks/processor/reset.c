/* The least that a Cortex-M needs to run: vectors, its floating-point unit, and memory as C expects it. */
#include <stdint.h>
#include <string.h>
#include "target.h"

extern uint32_t stack_top[], data_start[], data_end[], data_load[], zero_start[], zero_end[];
int main(void);
void reset(void);

/* A semihosting call: the emulator does it in the machine's place. */
long host(long operation, const void *arguments)
{
    register long r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(long reason)
{
    host(SYS_EXIT, (void *)reason);
    for (;;) {
    }
}

void reset(void)
{
    uint32_t *each, *top;
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: access to the floating-point unit */
    __asm__ volatile("dsb; isb");
    memcpy(data_start, data_load, (size_t)((char *)data_end - (char *)data_start));
    memset(zero_start, 0, (size_t)((char *)zero_end - (char *)zero_start));
    __asm__("mov %0, sp" : "=r"(top));
    for (each = zero_end; each < top - 64; each++)
        *each = UNTOUCHED;
    leave(main() ? RUN_TIME_ERROR : APPLICATION_EXIT);
}

static void fault(void)
{
    leave(RUN_TIME_ERROR);
}

/* Bytes of stack that were touched since the reset. */
uint32_t stack_used(void)
{
    const uint32_t *each = zero_end;
    while (*each == UNTOUCHED)
        each++;
    return (uint32_t)((const char *)stack_top - (const char *)each);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault};
