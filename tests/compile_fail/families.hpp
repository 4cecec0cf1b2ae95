// What the cases include.
#include <wayfare/decode.hpp>
#include <wayfare/filter.hpp>
#include <wayfare/graph.hpp>
#include <wayfare/motion.hpp>
#include <wayfare/pedestrian.hpp>
#include <wayfare/slam.hpp>
