// SPDX-License-Identifier: 0BSD
// Runs a sketch on this computer: setup(), then loop() some thousand times. Exit status 0 if it printed no FAILED, and
// all that it wrote to a pin was a duty of 0 .. 255.
#include <stdio.h>

#include "Arduino.h"

SerialPort Serial;
static unsigned long now;
static int failures, written;

void pinMode(int, int) {}
int digitalRead(int) { return now / 500000 % 3 == 2 ? LOW : HIGH; }
int analogRead(int) { return static_cast<int>((now / 3000 * 37) % 2048 > 1023 ? 1023 : (now / 3000 * 37) % 2048); }
unsigned long micros() { return now += 100; }
void delay(unsigned long milliseconds) { now += 1000 * milliseconds; }

void analogWrite(int, int value)
{
    failures += value < 0 || value > 255;
    ++written;
}

void SerialPort::begin(long) {}
void SerialPort::print(int value) { printf("%d", value); }
void SerialPort::print(double value) { printf("%.2f", value); }

void SerialPort::print(const char *text)
{
    failures += strstr(text, "FAILED") != nullptr;
    printf("%s", text);
}

void SerialPort::println(const char *text)
{
    print(text);
    printf("\n");
}

int main()
{
    setup();
    for (int i = 0; i < 100000; ++i) loop();
    if (written > 0) printf("%d duties written: %s\n", written, failures ? "FAILED" : "all within 0 .. 255");
    return failures ? 1 : 0;
}
