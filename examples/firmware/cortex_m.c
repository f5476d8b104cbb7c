/* From reset to main() on a Cortex-M: vector table, floating-point unit, printf by semihosting. Your board has its own. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t stack_top[], bss_begin[], end[];
extern void initialise_monitor_handles(void); /* of newlib: printf goes to the debugger, or to qemu */
int main(void);

void _fini(void) {}

static void fault(void)
{
    abort();
}

static void start(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: the floating-point unit is on */
    __asm volatile("dsb\n isb");
    for (uint32_t *to = bss_begin; to < end; ++to) *to = 0;
    initialise_monitor_handles();
    exit(main());
}

/* Initial stack pointer, reset, faults. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*entries[15])(void);
} vectors = {stack_top, {start, fault, fault, fault, fault, fault}};
