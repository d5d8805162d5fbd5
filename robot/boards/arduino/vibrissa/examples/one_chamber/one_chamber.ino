// The regulator alone, for a program of your own: holds 0.05 MPa in one chamber, and prints its pressure.

#include <math.h>
#include <regulator.h>

static const uint8_t FILL_PIN = 4, VENT_PIN = 5, PRESSURE_PIN = A0;

static vibrissa::Regulator regulator;
static uint8_t open_pin;
static uint32_t begin_us, pulse_us, printed_ms;

static void open_valve(uint8_t pin, uint32_t us) {
    digitalWrite(FILL_PIN, LOW);
    digitalWrite(VENT_PIN, LOW);
    open_pin = us ? pin : 0;
    pulse_us = us;
    begin_us = micros();
    if (open_pin) digitalWrite(open_pin, HIGH);
}

void setup() {
    pinMode(FILL_PIN, OUTPUT);
    pinMode(VENT_PIN, OUTPUT);
    Serial.begin(115200);
    regulator.set_target(0.05f, 0.0f);
}

void loop() {
    if (open_pin && micros() - begin_us >= pulse_us) open_valve(0, 0);
    float mpa = ((analogRead(PRESSURE_PIN) + 0.5f) * (5.0f / 1024.0f) - 1.0f) / 4.0f;
    vibrissa::Command command = regulator.step(micros(), mpa, NAN);
    if (command.kind == vibrissa::FILL) open_valve(FILL_PIN, command.us);
    if (command.kind == vibrissa::VENT) open_valve(VENT_PIN, command.us);
    if (command.kind == vibrissa::CLOSE) open_valve(0, 0);
    if (millis() - printed_ms < 250) return;
    printed_ms = millis();
    Serial.print(mpa, 4);
    Serial.print(' ');
    Serial.println(vibrissa::word(regulator.condition()));
}
