/* Values as text and back: *_TO_STRING and STRING_TO_* (docs/semantics.md). Needs snprintf and strtod. */
#include "ldc_runtime.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND UINT64_C(1000000000)
#define ERA 146097
#define EPOCH 719162

static const struct { const char *name; uint64_t size; } UNITS[] = {
    {"d", 86400 * SECOND}, {"h", 3600 * SECOND}, {"m", 60 * SECOND}, {"s", SECOND}, {"ms", 1000000}, {"us", 1000},
    {"ns", 1}};
static const uint8_t DAYS[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};

/* ---- printing */

static void put(uint8_t *into, uint32_t cap, uint32_t size, const char *text) {
    uint32_t count = (uint32_t)strlen(text);
    if (count > cap) count = cap;
    for (uint32_t i = 0; i < count; i++) {
        into[2 + i * size] = (uint8_t)text[i];
        if (size == 2) into[3 + i * size] = 0;
    }
    into[0] = (uint8_t)count;
    into[1] = (uint8_t)(count >> 8);
}

void ldc_print_bool(uint8_t *into, uint32_t cap, uint32_t size, uint8_t v) {
    put(into, cap, size, v ? "TRUE" : "FALSE");
}

void ldc_print_i64(uint8_t *into, uint32_t cap, uint32_t size, int64_t v) {
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)v);
    put(into, cap, size, text);
}

void ldc_print_u64(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v) {
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)v);
    put(into, cap, size, text);
}

void ldc_print_bits(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v) {
    char text[24];
    snprintf(text, sizeof text, "16#%llX", (unsigned long long)v);
    put(into, cap, size, text);
}

/* The fewest digits that read back as the value; as a decimal number where its exponent is small. */
static void real(uint8_t *into, uint32_t cap, uint32_t size, double v, int single) {
    char raw[40], digits[24], text[64], *out = text;
    if (v != v || isinf(v)) {
        put(into, cap, size, v != v ? "nan" : v > 0 ? "inf" : "-inf");
        return;
    }
    for (int precision = 0; precision < (single ? 9 : 17); precision++) {
        snprintf(raw, sizeof raw, "%.*e", precision, v);
        double back = strtod(raw, 0);
        if ((single ? (double)(float)back : back) == v) break;
    }
    char *power = strchr(raw, 'e'), *from = raw;
    int exponent = atoi(power + 1), count = 0;
    if (*from == '-') *out++ = *from++;
    for (; from < power; from++)
        if (*from != '.') digits[count++] = *from;
    digits[count] = 0;
    if (exponent < -4 || exponent >= 16) {
        snprintf(out, 48, "%c.%se%c%02d", digits[0], count > 1 ? digits + 1 : "0", exponent < 0 ? '-' : '+',
                 abs(exponent));
    } else if (exponent < 0) {
        snprintf(out, 48, "0.%.*s%s", -exponent - 1, "000", digits);
    } else {
        for (int i = 0; i <= exponent; i++) *out++ = i < count ? digits[i] : '0';
        snprintf(out, 32, ".%s", count > exponent + 1 ? digits + exponent + 1 : "0");
    }
    put(into, cap, size, text);
}

void ldc_print_single(uint8_t *into, uint32_t cap, uint32_t size, float v) { real(into, cap, size, v, 1); }
void ldc_print_real(uint8_t *into, uint32_t cap, uint32_t size, double v) { real(into, cap, size, v, 0); }

void ldc_print_time(uint8_t *into, uint32_t cap, uint32_t size, int64_t v) {
    char text[96];
    uint64_t rest = v < 0 ? 0 - (uint64_t)v : (uint64_t)v;
    int at = snprintf(text, sizeof text, v ? v < 0 ? "T#-" : "T#" : "T#0ms");
    for (uint32_t i = 0; i < 7; i++) {
        uint64_t count = rest / UNITS[i].size;
        rest %= UNITS[i].size;
        if (count)
            at += snprintf(text + at, sizeof text - (size_t)at, "%llu%s", (unsigned long long)count, UNITS[i].name);
    }
    put(into, cap, size, text);
}

static int date(char *text, size_t room, uint64_t days) {
    uint64_t count = days + EPOCH, year = count / ERA * 400;
    uint32_t rest = (uint32_t)(count % ERA), centuries = rest / 36524, month = 0;
    rest %= 36524;
    uint32_t fours = rest / 1461, ones;
    rest %= 1461;
    ones = rest / 365;
    rest %= 365;
    year += centuries * 100 + fours * 4 + ones + 1;
    if (ones == 4 || centuries == 4) return snprintf(text, room, "%04llu-12-31", (unsigned long long)year - 1);
    uint32_t leap = ones == 3 && (fours != 24 || centuries == 3);
    while (rest >= DAYS[month] + (month == 1 ? leap : 0u)) {
        rest -= DAYS[month] + (month == 1 ? leap : 0u);
        month++;
    }
    return snprintf(text, room, "%04llu-%02u-%02u", (unsigned long long)year, (unsigned)month + 1, (unsigned)rest + 1);
}

static void clock_of(char *text, size_t room, uint64_t v) {
    uint64_t seconds = v / SECOND, rest = v % SECOND;
    int at = snprintf(text, room, "%02u:%02u:%02u", (unsigned)(seconds / 3600), (unsigned)(seconds / 60 % 60),
                      (unsigned)(seconds % 60));
    if (!rest) return;
    at += snprintf(text + at, room - (size_t)at, ".%09u", (unsigned)rest);
    while (text[at - 1] == '0') text[--at] = 0;
}

void ldc_print_date(uint8_t *into, uint32_t cap, uint32_t size, uint32_t v) {
    char text[48] = "D#";
    date(text + 2, sizeof text - 2, v);
    put(into, cap, size, text);
}

void ldc_print_tod(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v) {
    char text[48] = "TOD#";
    clock_of(text + 4, sizeof text - 4, v % LDC_DAY);
    put(into, cap, size, text);
}

void ldc_print_dt(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v) {
    char text[64] = "DT#";
    int at = 3 + date(text + 3, 32, v / LDC_DAY);
    text[at++] = '-';
    clock_of(text + at, sizeof text - (size_t)at, v % LDC_DAY);
    put(into, cap, size, text);
}

/* ---- reading: a cursor over the text without the spaces around it */

typedef struct {
    const uint8_t *s;
    uint32_t size, at, end;
} cursor;

/* A character in lower case; 0 at the end and for what is not ASCII. */
static int peek(const cursor *c) {
    if (c->at >= c->end) return 0;
    uint32_t value = c->s[2 + c->at * c->size] | (c->size == 2 ? (uint32_t)c->s[3 + c->at * 2] << 8 : 0);
    if (value >= 'A' && value <= 'Z') value += 'a' - 'A';
    return value < 128 ? (int)value : 0;
}

static cursor over(const uint8_t *s, uint32_t size) {
    cursor c = {s, size, 0, ldc_length(s)};
    while (peek(&c) == ' ') c.at++;
    while (c.end > c.at) {
        cursor last = {s, size, c.end - 1, c.end};
        if (peek(&last) != ' ') break;
        c.end--;
    }
    return c;
}

static int take(cursor *c, const char *word) {
    cursor tried = *c;
    for (; *word; word++, tried.at++)
        if (peek(&tried) != *word) return 0;
    *c = tried;
    return 1;
}

static int done(const cursor *c) { return c->at == c->end; }
static int is_digit(int c) { return c >= '0' && c <= '9'; }

/* `least` to `most` digits; how many there were, 0 when too few. */
static uint32_t digits_of(cursor *c, uint32_t least, uint32_t most, uint64_t *value) {
    uint32_t count = 0;
    for (*value = 0; count < most && is_digit(peek(c)); c->at++, count++) *value = *value * 10 + (uint64_t)(peek(c) - '0');
    return count < least ? 0 : count;
}

static int figure(int c) { return is_digit(c) ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : 99; }

/* Digits of a base with single _ between them; 0 when there are none, or more than 64 bits. */
static int number(cursor *c, uint32_t base, uint64_t *value) {
    int any = 0, fits = 1;
    for (*value = 0;; c->at++) {
        int next = peek(c);
        if (next == '_' && any) {
            cursor after = *c;
            after.at++;
            if (figure(peek(&after)) >= (base == 10 ? 10 : 16)) return 0;
            continue;
        }
        if (figure(next) >= (base == 10 ? 10 : 16)) return any && fits;
        any = 1;
        fits &= figure(next) < (int)base && !__builtin_mul_overflow(*value, base, value)
                && !__builtin_add_overflow(*value, (uint64_t)figure(next), value);
    }
}

static int integer(const uint8_t *s, uint32_t size, int *negative, uint64_t *value) {
    cursor c = over(s, size), based = c;
    uint32_t base = take(&based, "2#") ? 2 : take(&based, "8#") ? 8 : take(&based, "16#") ? 16 : 0;
    *negative = 0;
    if (base) return number(&based, base, value) && done(&based);
    if (take(&c, "-")) *negative = 1;
    else take(&c, "+");
    return number(&c, 10, value) && done(&c);
}

uint8_t ldc_read_bool(const uint8_t *s, uint32_t size) {
    cursor c = over(s, size);
    return (uint8_t)((take(&c, "true") || take(&c, "1")) && done(&c));
}

int64_t ldc_read_i64(const uint8_t *s, uint32_t size, int64_t low, int64_t high) {
    int negative;
    uint64_t value;
    if (!integer(s, size, &negative, &value)) return 0;
    if (negative) return value <= 0 - (uint64_t)low ? (int64_t)(0 - value) : 0;
    return value <= (uint64_t)high ? (int64_t)value : 0;
}

uint64_t ldc_read_u64(const uint8_t *s, uint32_t size, uint64_t high) {
    int negative;
    uint64_t value;
    if (!integer(s, size, &negative, &value) || (negative && value)) return 0;
    return value <= high ? value : 0;
}

/* Digits with single _ between them are copied without those. */
static int copied(cursor *c, char **out) {
    int any = 0;
    for (;; c->at++) {
        int next = peek(c);
        if (is_digit(next)) {
            *(*out)++ = (char)next;
            any = 1;
            continue;
        }
        cursor after = *c;
        after.at++;
        if (next != '_' || !any || !is_digit(peek(&after))) return any;
    }
}

static int real_text(cursor *c, char *out) {
    if (peek(c) == '+' || peek(c) == '-') *out++ = (char)c->s[2 + c->at++ * c->size];
    int infinite = take(c, "inf");
    if (infinite || take(c, "nan")) {
        memcpy(out, infinite ? "inf" : "nan", 4);
        return done(c);
    }
    if (!copied(c, &out)) return 0;
    if (take(c, ".")) {
        *out++ = '.';
        if (!copied(c, &out)) return 0;
    }
    if (take(c, "e")) {
        *out++ = 'e';
        if (peek(c) == '+' || peek(c) == '-') *out++ = (char)c->s[2 + c->at++ * c->size];
        uint32_t begin = c->at;
        for (; is_digit(peek(c)); c->at++) *out++ = (char)peek(c);
        if (c->at == begin) return 0;
    }
    *out = 0;
    return done(c);
}

double ldc_read_real(const uint8_t *s, uint32_t size) {
    cursor c = over(s, size);
    char text[c.end - c.at + 8];
    return real_text(&c, text) ? strtod(text, 0) : 0.0;
}

float ldc_read_single(const uint8_t *s, uint32_t size) { return (float)ldc_read_real(s, size); }

/* A fraction of a unit, cut: each digit by itself, from the last. */
static uint64_t fraction_of(const cursor *from, uint32_t count, uint64_t unit) {
    uint64_t rest = 0;
    cursor c = *from;
    for (uint32_t i = count; i-- > 0;) {
        c.at = from->at + i;
        rest = ((uint64_t)(peek(&c) - '0') * unit + rest) / 10;
    }
    return rest;
}

int64_t ldc_read_time(const uint8_t *s, uint32_t size) {
    static const uint8_t ORDER[] = {0, 1, 4, 2, 3, 5, 6}; /* ms before m */
    cursor c = over(s, size);
    if (!take(&c, "time#")) take(&c, "t#");
    int negative = take(&c, "-"), broken = 0;
    if (!negative) take(&c, "+");
    uint64_t total = 0, previous = UINT64_MAX;
    do {
        uint64_t whole = 0;
        uint32_t begin = c.at, fraction = 0;
        for (; is_digit(peek(&c)); c.at++)
            broken |= __builtin_mul_overflow(whole, (uint64_t)10, &whole)
                      | __builtin_add_overflow(whole, (uint64_t)(peek(&c) - '0'), &whole);
        if (c.at == begin) return 0;
        cursor digits = c;
        if (take(&c, ".")) {
            digits = c;
            for (; is_digit(peek(&c)); c.at++) fraction++;
            if (!fraction) return 0;
        }
        uint32_t unit = 0;
        while (unit < 7 && !take(&c, UNITS[ORDER[unit]].name)) unit++;
        if (unit == 7) return 0;
        uint64_t length = UNITS[ORDER[unit]].size, part;
        take(&c, "_");
        if (length >= previous || (fraction && !done(&c))) return 0;
        previous = length;
        if (fraction > 18) fraction = 18;
        broken |= __builtin_mul_overflow(whole, length, &part)
                  | __builtin_add_overflow(total, part, &total)
                  | __builtin_add_overflow(total, fraction_of(&digits, fraction, length), &total);
    } while (!done(&c));
    if (broken || total > (uint64_t)INT64_MAX + (uint64_t)negative) return 0;
    return negative ? (int64_t)(0 - total) : (int64_t)total;
}

/* Days since 1970-01-01. */
static int date_text(cursor *c, int64_t *days) {
    uint64_t year, month, day;
    if (!digits_of(c, 4, 8, &year) || !take(c, "-") || !digits_of(c, 1, 2, &month) || !take(c, "-")
        || !digits_of(c, 1, 2, &day)) return 0;
    int64_t before = (int64_t)year - 1;
    int leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    if (month < 1 || month > 12 || day < 1 || day > DAYS[month - 1] + (uint64_t)(month == 2 && leap)) return 0;
    int64_t count = before < 0 ? -366 : before * 365 + before / 4 - before / 100 + before / 400;
    for (uint64_t m = 1; m < month; m++) count += DAYS[m - 1] + (m == 2 && leap);
    *days = count + (int64_t)day - 1 - EPOCH;
    return 1;
}

static int clock_text(cursor *c, uint64_t *v) {
    uint64_t hours, minutes, seconds = 0, fraction = 0;
    if (!digits_of(c, 1, 2, &hours) || !take(c, ":") || !digits_of(c, 1, 2, &minutes)) return 0;
    if (take(c, ":")) {
        if (!digits_of(c, 1, 2, &seconds)) return 0;
        if (take(c, ".")) {
            uint32_t count = digits_of(c, 1, 9, &fraction);
            if (!count) return 0;
            for (; count < 9; count++) fraction *= 10;
        }
    }
    if (!done(c) || hours > 23 || minutes > 59 || seconds > 59) return 0;
    *v = (hours * 3600 + minutes * 60 + seconds) * SECOND + fraction;
    return 1;
}

uint32_t ldc_read_date(const uint8_t *s, uint32_t size) {
    cursor c = over(s, size);
    int64_t days;
    if (!take(&c, "date#")) take(&c, "d#");
    return date_text(&c, &days) && done(&c) && days >= 0 && days <= UINT32_MAX ? (uint32_t)days : 0;
}

uint64_t ldc_read_tod(const uint8_t *s, uint32_t size) {
    cursor c = over(s, size);
    uint64_t v;
    if (!take(&c, "time_of_day#")) take(&c, "tod#");
    return clock_text(&c, &v) ? v : 0;
}

uint64_t ldc_read_dt(const uint8_t *s, uint32_t size) {
    cursor c = over(s, size);
    int64_t days;
    uint64_t v, total;
    if (!take(&c, "date_and_time#")) take(&c, "dt#");
    if (!date_text(&c, &days) || !take(&c, "-") || !clock_text(&c, &v) || days < 0) return 0;
    if (__builtin_mul_overflow((uint64_t)days, (uint64_t)LDC_DAY, &total) || __builtin_add_overflow(total, v, &total)) return 0;
    return total;
}
