#pragma once

// Several devices recorded at once, controlled and replayed.

#include <wayfare/logger/clock_readings.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/device_messages.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/logger/serial_port.hpp>
#include <wayfare/logger/ti_commands.hpp>
