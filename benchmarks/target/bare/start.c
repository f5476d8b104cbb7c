/* From power on to main() on a Cortex-M, without any library: vector table, floating-point unit, memory. */
#include <stdint.h>

extern uint32_t image_end[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
int main(void);
void start(void);
void io_end(int status);

/* What a compiler may call for the copy of a struct; a library would bring its own. */
void *memset(void *to, int value, unsigned count)
{
    unsigned char *t = to;
    while (count--) *t++ = (unsigned char)value;
    return to;
}

void *memcpy(void *to, const void *from, unsigned count)
{
    for (unsigned i = 0; i < count; ++i) ((unsigned char *)to)[i] = ((const unsigned char *)from)[i];
    return to;
}

static void fault(void)
{
    io_end(99);
}

void start(void)
{
#ifdef __ARM_FP
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: full access to the coprocessors 10 and 11, the FPU */
    __asm volatile("dsb\n isb");
#endif
    const uint32_t *from = image_end;
    for (uint32_t *to = data_begin; to < data_end; ++to) *to = *from++;
    for (uint32_t *to = bss_begin; to < bss_end; ++to) *to = 0;
    io_end(main());
}

typedef void (*entry)(void);

/* Initial stack pointer, reset, then the exceptions of the core; no interrupt is used. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    entry entries[15];
} vectors = {stack_top,
             {start, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault}};
