// SPDX-License-Identifier: 0BSD
// A stand-in for Arduino's header of this name, so that the sketches can be compiled and run without it: only what they
// use. It is on the path of `make check` alone.
#ifndef ARDUINO_STAND_IN_H
#define ARDUINO_STAND_IN_H

#include <stdint.h>
#include <string.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define pgm_read_byte(address) (*(const uint8_t *)(address))
#define pgm_read_dword(address) (*(const uint32_t *)(address))
#endif
#define F(text) (text)

enum { LOW = 0, HIGH = 1, INPUT = 0, OUTPUT = 1, INPUT_PULLUP = 2, A0 = 14 };

void pinMode(int pin, int mode);
int digitalRead(int pin);
int analogRead(int pin);
void analogWrite(int pin, int value);
unsigned long micros();
void delay(unsigned long milliseconds);

struct SerialPort {
    void begin(long baud);
    void print(const char *text);
    void print(int value);
    void print(double value);
    void println(const char *text);
};
extern SerialPort Serial;

void setup();
void loop();

#endif
