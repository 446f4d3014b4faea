// A computer in place of a board: Arduino's own classes for printing (ArduinoCore-API), over the pins and the clock of `monitor.cpp`.
#pragma once
#include "api/ArduinoAPI.h"
#include <cmath>
using namespace arduino;
using std::abs;
struct Port : Stream {
    size_t write(uint8_t letter) override;
    using Print::write;
    int available() override;
    int read() override;
    int peek() override;
};
extern Port Serial;
