// Stand-in for Arduino's: only what the monitor needs.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
class __FlashStringHelper;
#define F(text) (reinterpret_cast<const __FlashStringHelper *>(text))
using std::abs;
typedef std::string String;
struct StringSumHelper : String { using String::String; };
struct Print {
    void print(float value, int digits = 2) { printf("%.*f", digits, (double)value); }
    void print(int value) { printf("%d", value); }
    void print(char value) { putchar(value); }
    void print(const char *value) { fputs(value, stdout); }
    void print(const String &value) { fputs(value.c_str(), stdout); }
    void print(const __FlashStringHelper *value) { fputs(reinterpret_cast<const char *>(value), stdout); }
    template <class T> void println(T value) { print(value); puts("\r"); }
    template <class T> void println(T value, int digits) { print(value, digits); puts("\r"); }
    void println() { puts("\r"); }
};
typedef Print Stream;
inline Print Serial;
using std::max;
using std::min;
typedef uint8_t byte;
typedef unsigned int word;
inline unsigned long micros() { return 0; }
inline unsigned long millis() { return 0; }
inline void delay(unsigned long) {}
inline void delayMicroseconds(unsigned long) {}
inline void noInterrupts() {}
inline void interrupts() {}
#define HIGH 1
#define LOW 0
#define constrain(value, low, high) ((value) < (low) ? (low) : (value) > (high) ? (high) : (value))


#define PI 3.14159265358979
