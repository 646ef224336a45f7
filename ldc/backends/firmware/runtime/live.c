/* Scans in real time: SysTick tells when the next one begins. A board gives inputs and takes outputs by
   defining `ldc_board_inputs` and `ldc_board_outputs`. */
#include "firmware.h"

#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)

__attribute__((weak)) void ldc_board_inputs(uint8_t *memory) { (void)memory; }
__attribute__((weak)) void ldc_board_outputs(const uint8_t *memory) { (void)memory; }

void ldc_tell_fault(uint32_t task) {
    static const char *const why[] = { "?", "division by zero", "index", "index", "watchdog" };
    uint32_t fault = LDC_SYSTEM(ldc_block)->fault;
    ldc_puts("ldc: task ");
    ldc_put_hex(task);
    ldc_puts(" stopped: ");
    ldc_puts(why[fault <= LDC_WATCHDOG ? fault : 0]);
    ldc_puts("\n");
}

__attribute__((weak)) void ldc_on_fault(uint32_t task) { ldc_tell_fault(task); }

static volatile uint32_t ticks;

void ldc_tick(void);
void ldc_tick(void) { ticks++; }

void ldc_live(void) {
    uint32_t last = 0;
    SYST_RVR = ldc_reload;
    SYST_CVR = 0;
    SYST_CSR = 7;
    for (;;) {
        ldc_board_inputs(ldc_block);
        ldc_scan();
        ldc_board_outputs(ldc_block);
        while (ticks - last < ldc_ticks) __asm__ volatile("wfi");
        last += ldc_ticks;
    }
}
