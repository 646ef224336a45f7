/* What the parts of firmware know of each other: tables of one program, the scan, the board. */
#ifndef LDC_FIRMWARE_H
#define LDC_FIRMWARE_H

#include "ldc_runtime.h"

/* Changes of memory as words: offset, then size in bytes and that many bytes, filled up to a whole word; or,
   with LDC_BITS set, the mask in the lowest byte and the new bits in the next one. */
#define LDC_BITS 0x80000000u

typedef struct {
    int64_t interval; /* nanoseconds; 0: every scan */
    uint64_t watchdog;
    const uint8_t *runs;
    const uint32_t *safe;
    uint32_t run_count, safe_words;
    uint32_t single, single_mask; /* SINGLE: byte and bits of it; no bits: the task has none */
} ldc_task;

/* Of the program (plant.c). */
extern const ldc_task ldc_tasks[];
extern const uint32_t ldc_task_count;
extern const int64_t ldc_period;
extern const uint32_t ldc_initial[];
extern const uint32_t ldc_initial_words;
extern const uint32_t ldc_reload, ldc_ticks; /* SysTick: cycles of a tick less 1, ticks of a scan */
extern uint8_t ldc_block[];
uint32_t ldc_size(void);
int32_t ldc_run(uint8_t *m, uint32_t program);
extern const uint32_t ldc_ranges[], ldc_range_count; /* offset and size of what is retained */
extern const uint32_t ldc_retain_key, ldc_retain_words;
extern uint32_t ldc_retained[];

/* The scan (scan.c). `ldc_on_fault` is called when a task stops: the record is in the block. */
void ldc_start(void);
void ldc_scan(void);
int64_t ldc_restore(void); /* retain.c: the time that goes on, 0 when nothing was kept */
void ldc_keep(int64_t now);
void ldc_change(const uint32_t *words, uint32_t count);
void ldc_on_fault(uint32_t task);

/* The board (startup.c, uart.c). */
void ldc_puts(const char *text);
void ldc_put_hex(uint32_t number);
void ldc_exit(uint32_t status) __attribute__((noreturn));
void *ldc_take(uint32_t bytes); /* memory that nobody gives back; 0 when there is none left */

/* How scans go: from a job that a debugger or QEMU has (job.c), in real time (live.c). */
int ldc_job(void);
void ldc_live(void);
void ldc_tell_fault(uint32_t task);

#endif
