// Reads flat JSON objects, and collects lines to send. All fixed text is in the flash: PSTR("...").
#pragma once

#include <Arduino.h>

namespace vibrissa {

// A part of a received line; 0 as its beginning: there is none.
struct Part {
    const char *begin;
    uint8_t length;
};

// The value of a field of a flat JSON object.
Part field(const char *line, const char *name_in_flash);
// The next `"key": value` from `at` on, which then is behind it: false at the end of the object. Sets `bad` if there is
// something else.
bool next_pair(const char *&at, Part &key, Part &value, bool &bad);
bool is_text(Part value, const char *text_in_flash);
bool is_text_of(Part value, const char *text);
bool is_key(Part key, const char *name_in_flash);
bool is_true(Part value);
// A number, or not a number if there is none.
float number(Part value);
// A whole number up to the limit, or -1.
long whole(Part value, long most);
// A whole object: of a line that lost its end, the last number may be another one.
bool is_whole(const char *line);

// Lines wait here, as a full serial buffer would hold up the valves. A line of 14 samples with the ways of a slide
// fits. A board with more memory has room for those of six whiskers. Lines of the configuration leave room for such a
// line.
#if RAMEND > 0x1000
static const uint16_t OUT_SIZE = 2048, SPARE_ROOM = 700;
#else
static const uint16_t OUT_SIZE = 432, SPARE_ROOM = 350;
#endif
void put(char byte);
void put(const char *text_in_flash);
void put_text(const char *text);
// Characters that a JSON string may have; others become `?`.
void put_part(Part part);
void put_number(uint32_t number);
// The number divided by a power of ten.
void put_fixed(int32_t number, uint8_t places);
void put_float(float number);
// A digital pin as `4`, an analog one as `"A0"`.
void put_pin(uint8_t pin);
// So many more bytes fit.
uint16_t out_room();
// Sends a few bytes: a fast serial line takes them all at once, and meanwhile nothing would be received.
void send();
// Sends everything, and waits for it. Only while all valves are closed.
void send_all();

}  // namespace vibrissa
