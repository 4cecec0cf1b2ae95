#pragma once

// Device bytes to messages: TI mmWave radars, Xsens units, RPLIDAR scanners,
// GNSS receivers (UBX, NMEA). No I/O, no heap.

#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/mt_setup.hpp>
#include <wayfare/decode/nmea.hpp>
#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_packet.hpp>
#include <wayfare/decode/rplidar_point.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/rplidar_start.hpp>
#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/ti_commands.hpp>
#include <wayfare/decode/ti_config.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/ti_header.hpp>
#include <wayfare/decode/ti_items.hpp>
#include <wayfare/decode/ti_refusal.hpp>
#include <wayfare/decode/ti_tracking.hpp>
#include <wayfare/decode/ubx.hpp>
#include <wayfare/decode/ubx_messages.hpp>
#include <wayfare/decode/xbus.hpp>
