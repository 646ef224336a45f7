/* Scans in virtual time by semihosting: `ldc.job` in the folder of the debugger or QEMU tells what to do,
   `ldc.trace` takes what happened (docs/firmware.md has the formats). */
#include "firmware.h"

enum { SYS_OPEN = 1, SYS_CLOSE = 2, SYS_WRITE = 5, SYS_READ = 6 };
enum { MAGIC = 0x4A43444C, BUFFER = 1024, WORDS = 32 };

static uint32_t call(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static uint32_t open(const char *name, uint32_t mode) {
    uint32_t length = 0;
    while (name[length]) length++;
    uint32_t arguments[3] = { (uint32_t)name, mode, length };
    return call(SYS_OPEN, arguments);
}

/* ---- the job, read in pieces */

static uint32_t job, trace;
static uint8_t in[BUFFER], out[BUFFER];
static uint32_t in_at, in_end, out_end;

static uint32_t word(void) {
    if (in_at == in_end) {
        uint32_t arguments[3] = { job, (uint32_t)in, BUFFER };
        in_end = BUFFER - call(SYS_READ, arguments);
        in_at = 0;
        if (in_end < 4) ldc_exit(3);
    }
    uint32_t value;
    __builtin_memcpy(&value, in + in_at, 4);
    in_at += 4;
    return value;
}

/* ---- the trace, written in pieces */

static void flush(void) {
    uint32_t arguments[3] = { trace, (uint32_t)out, out_end };
    if (out_end && call(SYS_WRITE, arguments)) ldc_exit(4);
    out_end = 0;
}

static void put(const uint8_t *data, uint32_t size) {
    while (size) {
        uint32_t part = BUFFER - out_end < size ? BUFFER - out_end : size;
        __builtin_memcpy(out + out_end, data, part);
        out_end += part;
        data += part;
        size -= part;
        if (out_end == BUFFER) flush();
    }
}

void ldc_on_fault(uint32_t task) {
    if (!trace) {
        ldc_tell_fault(task);
        return;
    }
    uint8_t head[2] = { 'F', (uint8_t)task };
    put(head, 2);
    put(ldc_block, sizeof(ldc_system));
}

/* One row of changes before a scan. */
static void change(uint32_t count) {
    uint32_t words[2 + WORDS];
    while (count--) {
        words[0] = word();
        words[1] = word();
        uint32_t more = words[1] & LDC_BITS ? 0 : (words[1] + 3) / 4;
        if (more > WORDS) ldc_exit(3);
        for (uint32_t i = 0; i < more; i++) words[2 + i] = word();
        ldc_change(words, 2 + more);
    }
}

int ldc_job(void) {
    job = open("ldc.job", 1);
    if (job == UINT32_MAX || word() != MAGIC) return 0;
    trace = open("ldc.trace", 5);
    if (trace == UINT32_MAX) ldc_exit(4);
    uint32_t scans = word(), restart = word(), watched = word();
    uint32_t *ranges = ldc_take(8 * watched);
    if (!ranges) ldc_exit(5);
    for (uint32_t i = 0; i < 2 * watched; i++) ranges[i] = word();
    uint32_t next = word();
    for (uint32_t scan = 0; scan < scans; scan++) {
        if (scan == restart) ldc_start();
        if (scan == next) {
            change(word());
            next = word();
        }
        ldc_scan();
        put((const uint8_t *)"S", 1);
        for (uint32_t i = 0; i < watched; i++) put(ldc_block + ranges[2 * i], ranges[2 * i + 1]);
    }
    put((const uint8_t *)"E", 1);
    put(ldc_block, ldc_size());
    flush();
    call(SYS_CLOSE, &trace);
    ldc_exit(0);
}
