/* Something to count that is known: 2 n + 1 instructions of a loop, of a conditional block and of the FPU. */
#include <stdint.h>

#include "io.h"

__attribute__((naked, noinline)) static uint32_t counted(uint32_t n)
{
    (void)n;
    __asm volatile("1: subs r0, #1\n bne 1b\n bx lr");
}

/* 3 instructions whether the condition holds or not. */
__attribute__((naked, noinline)) static uint32_t conditional(uint32_t n)
{
    (void)n;
    __asm volatile("cmp r0, #1\n ite eq\n moveq r0, #7\n movne r0, #8\n bx lr");
}

__attribute__((noinline)) static void steps(uint32_t samples)
{
    for (uint32_t k = 0; k < samples; ++k) {
        uint32_t n = 0;
        io_read(&n, sizeof n);
        n = n > 1000 ? conditional(n - 1000) : counted(n);
        io_write(&n, sizeof n);
    }
}

int main(void)
{
    uint32_t samples = 0;
    io_read(&samples, sizeof samples);
    steps(samples);
    return 0;
}
