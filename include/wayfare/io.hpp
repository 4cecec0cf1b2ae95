#pragma once

// Files: CARMEN logs, ROS 1 bags, MCAP, RINEX, g2o, TUM, columns of text, map images and reports.

#include <wayfare/io/bag.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/growing_landmark_graph.hpp>
#include <wayfare/io/landmark_graph.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/nav_recording.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/observations.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/track_formats.hpp>
#include <wayfare/io/tum.hpp>
