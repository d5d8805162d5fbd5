// A board for the agent vibrissa-robot: two whiskers on an Uno, six on a Mega. Pins and sensors are set over the serial
// line; robot/boards/README.md has the wiring and docs/driver-interface.md the lines.

#include <vibrissa.h>

void setup() { vibrissa::begin(); }

void loop() { vibrissa::loop(); }
