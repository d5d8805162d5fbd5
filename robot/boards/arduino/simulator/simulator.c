// Runs the sketch on a simulated microcontroller (libsimavr) with simulated chambers and converters on its pins.
//
// simulator uno|mega ELF < SCRIPT. Each line of the script is a time in ms since the start and what happens then: a
// line that is sent to the board, or an order of the simulator:
//
//   !end                                    end
//   !supply MPA                             pressure of the supply
//   !sensor VOLTS                           sensor of the first chamber; -1: it follows the chamber
//   !chamber N FILL_PIN VENT_PIN CHANNEL    wires chamber N; chamber 0 is at 4 5 0
//   !volts CHANNEL VOLTS                    an analog input
//   !hx711 N DATA_PIN CLOCK_PIN HZ          wires an HX711
//   !bridge N VOLTS                         the voltage between its inputs
//   !broken N LEVEL                         it does not answer: its data line stays at this level
//   !ads1115 N ADDRESS                      wires an ADS1115
//   !input N INPUT VOLTS                    the voltage of one of its inputs
//   !eeprom ADDRESS BYTE                    overwrites a byte of the EEPROM
//   !restart                                resets the microcontroller; the EEPROM keeps its bytes
//   !pressures                              prints the true pressures of all chambers, and all lines so far: a
//                                           program that waits for it may write the next lines then
//   !stack                                  prints the fewest bytes between variables and stack so far
//
// Prints each line of the board after the simulated time in ms and the true pressure of the first chamber, and the
// valves whenever they change, with the pressure of their chamber.
#include "simulator.h"

#include <simavr/avr_adc.h>
#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TICK_US 100

avr_t *avr;
int is_mega;
static avr_irq_t *adc;
static char said[1000];
static size_t said_length;
static int variables_end, least_stack;
// Bytes on their way to the board.
static char sending[65536];
static size_t sent, to_send;
static avr_uart_t *uart;

double now_ms(void) { return avr->cycle / (1000.0 * MHZ); }

// Port and bit of the digital pins.
static const char mega_pins[] = "E0E1E4E5G5E3H3H4H5H6B4B5B6B7J1J0H1H0D3D2D1D0A0A1A2A3A4A5A6A7C7C6C5C4C3C2C1C0D7G2G1G0"
                                "L7L6L5L4L3L2L1L0B3B2B1B0F0F1F2F3F4F5F6F7K0K1K2K3K4K5K6K7";
static const char uno_pins[] = "D0D1D2D3D4D5D6D7B0B1B2B3B4B5C0C1C2C3C4C5";

avr_irq_t *pin_irq(int pin) {
    const char *place = (is_mega ? mega_pins : uno_pins) + 2 * pin;
    return avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(place[0]), place[1] - '0');
}

void set_pin(int pin, int level) {
    // Otherwise each write to the port would read as the pull-up of the pin.
    static struct {
        uint8_t mask, value;
    } driven[26];
    const char *place = (is_mega ? mega_pins : uno_pins) + 2 * pin;
    uint8_t port = place[0] - 'A', bit = 1 << (place[1] - '0');
    driven[port].mask |= bit;
    driven[port].value = (driven[port].value & ~bit) | (level ? bit : 0);
    avr_ioport_external_t external = {.name = place[0], .mask = driven[port].mask, .value = driven[port].value};
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(place[0]), &external);
    avr_raise_irq(pin_irq(pin), level);
}

static void on_byte(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    if (value == '\n' || said_length == sizeof said - 1) {
        said[said_length] = 0;
        printf("%.1f %.5f %s\n", now_ms(), chamber_mpa(0), said);
        said_length = 0;
    } else {
        said[said_length++] = value;
    }
}

// Bytes come as fast as the board's baud rate allows: the library hands one over after the time of a byte.
static void send_byte(avr_irq_t *input) {
    if (sent == to_send || uart->input.read != uart->input.write) return;
    avr_raise_irq(input, (uint8_t)sending[sent++]);
    if (sent == to_send) sent = to_send = 0;
}

static void on_adc(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    set_analog_inputs(adc, value);
}

static void write_eeprom(int address, int byte) {
    uint8_t value = byte;
    avr_eeprom_desc_t place = {.ee = &value, .offset = address, .size = 1};
    avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &place);
}

// One order of the script; 1 at its end.
static int obey(const char *what) {
    int a, b, c, d;
    double x;
    if (!strncmp(what, "!end", 4)) return 1;
    if (sscanf(what, "!supply %lf", &x) == 1) supply_mpa = x;
    else if (sscanf(what, "!sensor %lf", &x) == 1) sensor_volts = x;
    else if (sscanf(what, "!chamber %d %d %d %d", &a, &b, &c, &d) == 4) wire_chamber(a, b, c, d);
    else if (sscanf(what, "!volts %d %lf", &a, &x) == 2) set_volts(a, x);
    else if (sscanf(what, "!hx711 %d %d %d %lf", &a, &b, &c, &x) == 4) wire_hx711(a, b, c, x);
    else if (sscanf(what, "!bridge %d %lf", &a, &x) == 2) set_hx711(a, x);
    else if (sscanf(what, "!broken %d %d", &a, &b) == 2) break_hx711(a, b);
    else if (sscanf(what, "!ads1115 %d %d", &a, &b) == 2) wire_ads1115(a, b);
    else if (sscanf(what, "!input %d %d %lf", &a, &b, &x) == 3) set_ads1115(a, b, x);
    else if (sscanf(what, "!eeprom %d %d", &a, &b) == 2) write_eeprom(a, b);
    else if (!strncmp(what, "!restart", 8)) avr_reset(avr);
    else if (!strncmp(what, "!stack", 6)) printf("%.1f 0 stack %d\n", now_ms(), least_stack);
    else if (!strncmp(what, "!pressures", 10)) {
        printf("%.1f 0 pressures", now_ms());
        for (int i = 0; i < CHAMBERS; i++) printf(" %.5f", chamber_mpa(i));
        printf("\n");
        fflush(stdout);
    } else {
        fprintf(stderr, "unknown order %s", what);
        exit(2);
    }
    return 0;
}

static void watch_stack(void) {
    int room = (avr->data[R_SPL] | avr->data[R_SPH] << 8) - variables_end;
    // Before the program has set it, the pointer is 0.
    if (room > -variables_end + 255 && room < least_stack) least_stack = room;
}

static int set_up(const char *elf) {
    elf_firmware_t firmware = {{0}};
    if (elf_read_firmware(elf, &firmware)) return 0;
    avr = avr_make_mcu_by_name(is_mega ? "atmega2560" : "atmega328p");
    if (!avr) return 0;
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = MHZ * 1000000;
    avr_load_firmware(avr, &firmware);
    avr->vcc = avr->avcc = avr->aref = 5000;
    variables_end = (is_mega ? 0x200 : 0x100) + firmware.datasize + firmware.bsssize;
    least_stack = avr->ramend - variables_end;
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (!strcmp(io->kind, "uart") && ((avr_uart_t *)io)->name == '0') uart = (avr_uart_t *)io;
    }
    if (!uart) return 0;
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte, NULL);
    adc = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
    avr_irq_register_notify(adc + ADC_IRQ_OUT_TRIGGER, on_adc, NULL);
    place_upper_inputs(avr);
    wire_chamber(0, 4, 5, 0);
    return 1;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "simulator uno|mega ELF < SCRIPT\n");
        return 2;
    }
    is_mega = !strcmp(argv[1], "mega");
    if (!set_up(argv[2])) return 2;
    avr_irq_t *input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    char line[4096];
    double at_ms = -1;
    avr_cycle_count_t tick = 0;
    for (;;) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "the microcontroller stopped\n");
            return 3;
        }
        watch_stack();
        send_byte(input);
        if (avr->cycle < tick) continue;
        tick += TICK_US * MHZ;
        move_air(TICK_US * 1e-6);
        run_devices();
        for (;;) {
            if (at_ms < 0) {
                if (!fgets(line, sizeof line, stdin)) return 0;
                at_ms = atof(line);
            }
            if (now_ms() < at_ms) break;
            char *what = strchr(line, ' ');
            at_ms = -1;
            if (!what) return 0;
            if (what[1] == '!') {
                if (obey(what + 1)) return 0;
                continue;
            }
            size_t length = strlen(what + 1);
            if (to_send + length > sizeof sending) {
                fprintf(stderr, "the lines to the board are too many\n");
                return 2;
            }
            memcpy(sending + to_send, what + 1, length);
            to_send += length;
        }
    }
}
