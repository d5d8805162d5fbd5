// Reads vectors that a test of the Rust regulator has written, runs the C++ regulator on them, and names the first line
// that differs. A line is `target MPA SLEW`, or `TIME_US READING_BITS SUPPLY_BITS COMMAND LENGTH_US CONDITION`; `new`
// begins anew.
#include <cstdio>
#include <cstring>
#include <string>

#include "../vibrissa/src/regulator.h"

static float from_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

int main() {
    static const char *const kinds[] = {"NONE", "FILL", "VENT", "CLOSE"};
    vibrissa::Regulator regulator;
    char line[200], kind[10], condition[12];
    unsigned long number = 0, compared = 0;
    while (fgets(line, sizeof line, stdin)) {
        number++;
        unsigned long long now;
        unsigned reading, supply, us;
        if (!strncmp(line, "new", 3)) {
            regulator = vibrissa::Regulator();
        } else if (sscanf(line, "target %x %x", &reading, &supply) == 2) {
            regulator.set_target(from_bits(reading), from_bits(supply));
        } else if (sscanf(line, "%llu %x %x %9s %u %11s", &now, &reading, &supply, kind, &us, condition) == 6) {
            vibrissa::Command command = regulator.step((uint32_t)now, from_bits(reading), from_bits(supply));
            compared++;
            if (strcmp(kinds[command.kind], kind) || command.us != us
                || strcmp(vibrissa::word(regulator.condition()), condition)) {
                printf("line %lu: expected %s %u %s, got %s %u %s\n", number, kind, us, condition, kinds[command.kind],
                       (unsigned)command.us, vibrissa::word(regulator.condition()));
                return 1;
            }
        } else {
            printf("line %lu is none of a vector: %s", number, line);
            return 1;
        }
    }
    printf("%lu steps agree\n", compared);
    return compared == 0;
}
