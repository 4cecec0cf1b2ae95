#pragma once

// A genetic algorithm and the INS filter parameters it tunes.

#include <wayfare/tune/genetic.hpp>
#include <wayfare/tune/ins_fitness.hpp>
