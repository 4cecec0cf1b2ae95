#pragma once

// A genetic algorithm and the parameters of the INS filter it tunes.

#include <wayfare/tune/genetic.hpp>
#include <wayfare/tune/ins_fitness.hpp>
#include <wayfare/tune/ins_genes.hpp>
