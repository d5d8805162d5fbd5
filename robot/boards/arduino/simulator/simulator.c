// Runs the sketch on a simulated microcontroller (libsimavr) with a simulated chamber on its pins.
//
// simulator uno|mega ELF < SCRIPT. Each line of the script is a time in ms since the start and what happens then: a
// line that is sent to the board; or `!supply MPA`, `!sensor VOLTS` (-1: follows the chamber), `!end`. Prints each line
// of the board after the simulated time in ms and the true pressure, and the valves whenever they change.
#include <math.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MHZ 16
#define TICK_US 100

static avr_t *avr;
static avr_irq_t *adc;
static double pressure_mpa, supply_mpa = 0.25, sensor_volts = -1, tau_s = 0.8, fill_open, vent_open;
static int fill, vent;
static char said[1000];
static size_t said_length;

static double now_ms(void) { return avr->cycle / (1000.0 * MHZ); }

static void on_byte(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    if (value == '\n' || said_length == sizeof said - 1) {
        said[said_length] = 0;
        printf("%.1f %.5f %s\n", now_ms(), pressure_mpa, said);
        said_length = 0;
    } else {
        said[said_length++] = value;
    }
}

static void on_adc(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value, (void)param;
    double volts = sensor_volts < 0 ? 1 + 4 * pressure_mpa : sensor_volts;
    avr_raise_irq(adc + ADC_IRQ_ADC0, (uint32_t)lround(volts * 1000));
    avr_raise_irq(adc + ADC_IRQ_ADC1, 2500 + (uint32_t)lround(200 * pressure_mpa));
}

static void on_valve(avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq;
    *(int *)param = value;
    printf("%.1f %.5f valves %d %d\n", now_ms(), pressure_mpa, fill, vent);
}

static double orifice(double from_mpa, double chamber_mpa) {
    double from = from_mpa + 0.1013, to = chamber_mpa + 0.1013, sign = from > to ? 1 : -1;
    double up = fmax(from, to), ratio = fmin(from, to) / up;
    return sign * up * (ratio < 0.528 ? 1 : sqrt(fmax(0, 1 - pow((ratio - 0.528) / 0.472, 2))));
}

static double towards(double position, int open) {
    return fmin(1, fmax(0, position + (open ? TICK_US / 5000.0 : -TICK_US / 3000.0)));
}

static void chamber(void) {
    fill_open = towards(fill_open, fill);
    vent_open = towards(vent_open, vent);
    double rate = fill_open * orifice(supply_mpa, pressure_mpa) + vent_open * orifice(0, pressure_mpa);
    pressure_mpa += rate / tau_s * TICK_US * 1e-6;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "simulator uno|mega ELF < SCRIPT\n");
        return 2;
    }
    int mega = !strcmp(argv[1], "mega");
    elf_firmware_t firmware = {{0}};
    if (elf_read_firmware(argv[2], &firmware)) return 2;
    avr = avr_make_mcu_by_name(mega ? "atmega2560" : "atmega328p");
    if (!avr) return 2;
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = MHZ * 1000000;
    avr_load_firmware(avr, &firmware);
    avr->vcc = avr->avcc = avr->aref = 5000;
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_t *output = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT);
    avr_irq_t *input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(output, on_byte, NULL);
    adc = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
    avr_irq_register_notify(adc + ADC_IRQ_OUT_TRIGGER, on_adc, NULL);
    // Digital pins 4 and 5 of the two boards.
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(mega ? 'G' : 'D'), mega ? 5 : 4), on_valve, &fill);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(mega ? 'E' : 'D'), mega ? 3 : 5), on_valve, &vent);

    char line[400], *sending = NULL;
    double at_ms = -1;
    avr_cycle_count_t tick = 0;
    for (;;) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "the microcontroller stopped\n");
            return 3;
        }
        if (avr->cycle < tick) continue;
        tick += TICK_US * MHZ;
        chamber();
        if (sending) {
            // A byte each tick: a little slower than 115200 baud.
            avr_raise_irq(input, (uint8_t)*sending);
            sending = *sending == '\n' ? NULL : sending + 1;
            continue;
        }
        if (at_ms < 0) {
            if (!fgets(line, sizeof line, stdin)) return 0;
            at_ms = atof(line);
        }
        if (now_ms() < at_ms) continue;
        char *what = strchr(line, ' ');
        at_ms = -1;
        if (!what) return 0;
        what++;
        if (!strncmp(what, "!end", 4)) return 0;
        if (!strncmp(what, "!supply ", 8)) supply_mpa = atof(what + 8);
        else if (!strncmp(what, "!sensor ", 8)) sensor_volts = atof(what + 8);
        else sending = what;
    }
}
