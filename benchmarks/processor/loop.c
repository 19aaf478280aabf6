/* The law as the controller: takes inputs from one pipe, gives outputs and what a step cost to another.

   Compiled with LAW (the law's name) and its header included. */
#include <stddef.h>
#include "target.h"

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
typedef NAMED(LAW, _inputs) inputs_of_law;
typedef NAMED(LAW, _outputs) outputs_of_law;

/* SysTick counts down 24 bits of the processor's clock. */
static volatile uint32_t *const control = (uint32_t *)0xE000E010, *const reload = (uint32_t *)0xE000E014,
                                *const ticks = (uint32_t *)0xE000E018;

static struct {
    int32_t begins;
    inputs_of_law inputs;
} asked;
static struct {
    outputs_of_law outputs;
    uint32_t ticks, calibration, stack, memory;
} answer;

static LAW law;

static long opened(const char *name, uint32_t length, uint32_t mode)
{
    const uint32_t arguments[] = {(uint32_t)name, mode, length};
    return host(SYS_OPEN, arguments);
}

/* Passes a whole block; returns 0 at the end of the pipe. */
static int passed(long operation, long file, void *block, uint32_t size)
{
    while (size) {
        const uint32_t arguments[] = {(uint32_t)file, (uint32_t)block, size};
        uint32_t left = (uint32_t)host(operation, arguments);
        if (left >= size)
            return 0;
        block = (char *)block + (size - left);
        size = left;
    }
    return 1;
}

/* Ticks of 1000 instructions. */
static uint32_t ticks_of_known_work(void)
{
    const uint32_t before = *ticks;
    __asm__ volatile(".rept 1000\n nop\n .endr");
    return (before - *ticks) & 0xFFFFFF;
}

int main(void)
{
    const long inputs = opened("inputs", 6, 1), outputs = opened("outputs", 7, 5);
    uint32_t before;
    *reload = 0xFFFFFF;
    *ticks = 0;
    *control = 5; /* on, by the processor's clock, without an interrupt */
    answer.calibration = ticks_of_known_work();
    answer.memory = sizeof law;
    while (passed(SYS_READ, inputs, &asked, sizeof asked)) {
        before = *ticks;
        if (asked.begins)
            NAMED(LAW, _init)(&law, &asked.inputs RECALLS);
        else
            NAMED(LAW, _step)(&law, &asked.inputs);
        answer.ticks = (before - *ticks) & 0xFFFFFF;
        answer.outputs = law.outputs;
        answer.stack = stack_used();
        if (!passed(SYS_WRITE, outputs, &answer, sizeof answer))
            return 1;
    }
    return 0;
}
