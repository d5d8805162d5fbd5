// The lines `configure` and `configuration`: docs/driver-interface.md.
#pragma once

#include "settings.h"
#include "text.h"

namespace vibrissa {

// A line `configure`. The settings are changed in the memory alone.
enum Step : uint8_t { REFUSED, CHANGED, SAVE, DISCARD };
__attribute__((noinline)) Step configure(const char *line);
// Whether the settings as a whole can be used; otherwise says why they cannot.
__attribute__((noinline)) bool check();
// The next line that tells the configuration, from `at` = 0 on, if it fits; false after the last one.
__attribute__((noinline)) bool tell(uint8_t &at, Record record);

}  // namespace vibrissa
