/* One scan: inputs are there, tasks that are due run by priority, safe values follow (DESIGN sections 3 and
   5). */
#include "firmware.h"

#define TASKS_MOST 64

static struct {
    int64_t due;
    uint8_t single_before, stopped, wanted;
} states[TASKS_MOST];
static uint8_t order[TASKS_MOST]; /* stopped tasks, the first one first */
static uint32_t stopped;
static int64_t now;

void ldc_change(const uint32_t *words, uint32_t count) {
    uint32_t at = 0;
    while (at + 1 < count) {
        uint8_t *target = ldc_block + words[at];
        uint32_t size = words[at + 1];
        at += 2;
        if (size & LDC_BITS) {
            *target = (uint8_t)((*target & ~size) | (size >> 8 & size & 0xFF));
            continue;
        }
        __builtin_memcpy(target, words + at, size);
        at += (size + 3) / 4;
    }
}

void ldc_start(void) {
    __builtin_memset(ldc_block, 0, ldc_size());
    __builtin_memset(states, 0, sizeof states);
    stopped = 0;
    ldc_change(ldc_initial, ldc_initial_words);
    /* A timer that is retained goes on; the time without power does not count. */
    now = ldc_range_count ? ldc_restore() : 0;
    LDC_SYSTEM(ldc_block)->first_scan = 1;
}

static void choose(void) {
    for (uint32_t n = 0; n < ldc_task_count; n++) {
        const ldc_task *task = &ldc_tasks[n];
        uint8_t single = (ldc_block[task->single] & task->single_mask) != 0;
        uint8_t wanted = !task->interval && !task->single_mask;
        if (task->interval && now >= states[n].due) {
            wanted = !single;
            states[n].due = (now / task->interval + 1) * task->interval;
        }
        states[n].wanted = (wanted | (single & !states[n].single_before)) & !states[n].stopped;
        states[n].single_before = single;
    }
}

static void execute(uint32_t n) {
    const ldc_task *task = &ldc_tasks[n];
    LDC_SYSTEM(ldc_block)->watchdog = task->watchdog;
    for (uint32_t i = 0; i < task->run_count; i++) {
        if (ldc_run(ldc_block, task->runs[i]) != LDC_OK) {
            states[n].stopped = 1;
            order[stopped++] = (uint8_t)n;
            ldc_on_fault(n);
            return;
        }
    }
}

void ldc_scan(void) {
    LDC_SYSTEM(ldc_block)->now = now;
    choose();
    for (uint32_t n = 0; n < ldc_task_count; n++) {
        if (states[n].wanted) execute(n);
    }
    for (uint32_t n = 0; n < stopped; n++) {
        const ldc_task *task = &ldc_tasks[order[n]];
        ldc_change(task->safe, task->safe_words);
    }
    LDC_SYSTEM(ldc_block)->first_scan = 0;
    now += ldc_period;
    if (ldc_range_count) ldc_keep(now);
}
