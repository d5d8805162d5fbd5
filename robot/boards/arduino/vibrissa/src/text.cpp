#include "text.h"

#include <avr/wdt.h>
#include <math.h>
#include <string.h>

namespace vibrissa {

static const char *skip(const char *at) {
    while (*at == ' ') at++;
    return at;
}

// A string with its quotes, or everything up to a comma or the end of the object.
static Part value_at(const char *at) {
    const char *end = at;
    if (*at == '"') {
        end = strchr(at + 1, '"');
        if (!end) return {0, 0};
        end++;
    } else {
        while (*end && *end != ',' && *end != '}' && *end != ' ') end++;
    }
    return {at, (uint8_t)(end - at)};
}

Part field(const char *line, const char *name) {
    size_t length = strlen_P(name);
    for (const char *at = strchr(line, '"'); at; at = strchr(at + 1, '"')) {
        if (strncmp_P(at + 1, name, length) || at[length + 1] != '"') continue;
        const char *value = skip(at + length + 2);
        if (*value == ':') return value_at(skip(value + 1));
    }
    return {0, 0};
}

bool next_pair(const char *&at, Part &key, Part &value, bool &bad) {
    at = skip(at);
    if (*at == '}') return false;
    bad = true;
    if (*at == '{' || *at == ',') at = skip(at + 1);
    if (*at != '"') return false;
    key = value_at(at);
    if (!key.begin) return false;
    at = skip(at + key.length);
    key = {key.begin + 1, (uint8_t)(key.length - 2)};
    if (*at != ':') return false;
    value = value_at(skip(at + 1));
    if (!value.begin || !value.length) return false;
    at = skip(value.begin + value.length);
    bad = *at != ',' && *at != '}';
    return !bad;
}

bool is_key(Part key, const char *name) {
    return key.length == strlen_P(name) && !strncmp_P(key.begin, name, key.length);
}

static bool is_quoted(Part value) { return value.begin && value.length > 1 && value.begin[0] == '"'; }

bool is_text(Part value, const char *text) {
    return is_quoted(value) && is_key({value.begin + 1, (uint8_t)(value.length - 2)}, text);
}

bool is_text_of(Part value, const char *text) {
    size_t length = strlen(text);
    return is_quoted(value) && value.length == length + 2 && !strncmp(value.begin + 1, text, length);
}

bool is_true(Part value) { return is_key(value, PSTR("true")); }

static float times_ten(float number, int8_t power) {
    // 1e10 is the largest power of ten that a float has exactly.
    float scale = 1.0f;
    for (int8_t i = power < 0 ? -power : power; i > 0; i--) scale *= 10.0f;
    return power < 0 ? number / scale : number * scale;
}

// `strtod` of the library is larger, and takes words such as `inf`.
float number(Part value) {
    const char *at = value.begin, *end = at + value.length;
    if (!at || at == end) return NAN;
    bool negative = *at == '-', begun = false, point = false;
    uint32_t digits = 0;
    int8_t power = 0;
    for (at += negative; at < end; at++) {
        if (*at == '.' && !point) {
            point = true;
        } else if (*at >= '0' && *at <= '9') {
            begun = true;
            // Digits beyond those of a float are left out.
            bool fits = digits < 100000000;
            if (fits) digits = digits * 10 + (*at - '0');
            if (fits == point) power += point ? -1 : 1;
        } else {
            break;
        }
        if (power > 30 || power < -30) return NAN;
    }
    if (!begun) return NAN;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        bool down = at < end && *at == '-';
        if (at < end && (*at == '-' || *at == '+')) at++;
        long exponent = whole({at, (uint8_t)(end - at)}, 30);
        if (exponent < 0) return NAN;
        power += down ? -exponent : exponent;
        at = end;
    }
    if (at < end) return NAN;
    float number = times_ten(digits, power);
    return negative ? -number : number;
}

long whole(Part value, long most) {
    if (!value.begin || !value.length || value.length > 9) return -1;
    long parsed = 0;
    for (uint8_t i = 0; i < value.length; i++) {
        if (value.begin[i] < '0' || value.begin[i] > '9') return -1;
        parsed = parsed * 10 + (value.begin[i] - '0');
    }
    return parsed > most ? -1 : parsed;
}

bool is_whole(const char *line) {
    size_t length = strlen(line);
    while (length && (line[length - 1] == '\r' || line[length - 1] == ' ')) length--;
    return length && line[0] == '{' && line[length - 1] == '}';
}

static char out[OUT_SIZE];
static uint16_t out_begin, out_count;

void put(char byte) {
    uint16_t end = out_begin + out_count++;
    out[end < OUT_SIZE ? end : end - OUT_SIZE] = byte;
}

void put(const char *text) {
    while (char byte = pgm_read_byte(text++)) put(byte);
}

void put_text(const char *text) {
    while (*text) put(*text++);
}

void put_part(Part part) {
    for (uint8_t i = 0; i < part.length && i < 24; i++) {
        char byte = part.begin[i];
        if (byte != '"') put(byte < ' ' || byte > '~' || byte == '\\' ? '?' : byte);
    }
}

// The processor has no division: subtractions are six times as fast.
static void put_digits(uint32_t rest, uint8_t places) {
    static const uint32_t powers[] PROGMEM = {1000000000, 100000000, 10000000, 1000000, 100000,
                                              10000,      1000,      100,      10,      1};
    bool begun = false;
    for (uint8_t i = 0; i < 10; i++) {
        uint32_t power = pgm_read_dword(powers + i);
        char digit = '0';
        while (rest >= power) {
            rest -= power;
            digit++;
        }
        begun |= digit > '0' || 9 - i <= places;
        if (begun) put(digit);
        if (places && 9 - i == places) put('.');
    }
}

void put_number(uint32_t number) { put_digits(number, 0); }

void put_fixed(int32_t number, uint8_t places) {
    if (number < 0) put('-');
    put_digits(number < 0 ? 0 - (uint32_t)number : (uint32_t)number, places);
}

void put_float(float number) {
    // A float has seven digits.
    float size = fabs(number);
    uint8_t places = size < 0.01f ? 9 : size < 1.0f ? 7 : 6;
    for (; places && size >= 10.0f; size /= 10.0f) places--;
    int32_t fixed = lround(times_ten(number, places));
    while (places && fixed % 10 == 0) {
        fixed /= 10;
        places--;
    }
    put_fixed(fixed, places);
}

void put_pin(uint8_t pin) {
    if (pin < A0) return put_number(pin);
    put('"');
    put('A');
    put_number(pin - A0);
    put('"');
}

uint16_t out_room() { return OUT_SIZE - out_count; }

void send() {
    for (uint8_t most = 32; most && out_count && Serial.availableForWrite() > 0; most--) {
        Serial.write(out[out_begin]);
        if (++out_begin == OUT_SIZE) out_begin = 0;
        out_count--;
    }
}

void send_all() {
    while (out_count) {
        wdt_reset();
        send();
    }
    Serial.flush();
}

}  // namespace vibrissa
