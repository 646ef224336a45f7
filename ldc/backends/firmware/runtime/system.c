/* What newlib asks a system for when it turns numbers into text: memory, a way to give up, and files, of
   which there are none. */
#include "firmware.h"

void *_sbrk(int bytes);
void _exit(int status) __attribute__((noreturn));
int _kill(int process, int signal);
int _getpid(void);
int _write(int file, const void *data, unsigned count);
int _read(int file, void *data, unsigned count);
int _lseek(int file, int at, int from);
int _close(int file);
int _fstat(int file, void *about);
int _isatty(int file);

void *_sbrk(int bytes) {
    void *found = ldc_take((uint32_t)bytes);
    return found ? found : (void *)-1;
}

void _exit(int status) { ldc_exit((uint32_t)status); }

int _kill(int process, int signal) {
    (void)process;
    (void)signal;
    return -1;
}

int _getpid(void) { return 1; }

int _write(int file, const void *data, unsigned count) {
    (void)file;
    (void)data;
    (void)count;
    return -1;
}

int _read(int file, void *data, unsigned count) {
    (void)file;
    (void)data;
    (void)count;
    return -1;
}

int _lseek(int file, int at, int from) {
    (void)file;
    (void)at;
    (void)from;
    return -1;
}

int _close(int file) {
    (void)file;
    return -1;
}

int _fstat(int file, void *about) {
    (void)file;
    (void)about;
    return -1;
}

int _isatty(int file) {
    (void)file;
    return 0;
}
