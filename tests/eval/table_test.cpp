#include <wayfare/eval/table.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare::eval {
namespace {

TEST(Table, AlignsByCharactersNotBytes) {
  Table table({{"run"}, {"translation", "m"}, {"turn", "°"}});
  table.add_row({"odometry", mean_std(7.2249, 3.0, 2), fixed(40.06, 1)});
  table.add_row({"café", mean_std(0.1, NAN, 2), fixed(NAN, 1)});
  EXPECT_EQ(table.to_text(),
            "run       translation [m]  turn [°]\n"
            "--------  ---------------  --------\n"
            "odometry      7.22 ± 3.00      40.1\n"
            "café             0.10 ± –         –\n");
}

}  // namespace
}  // namespace wayfare::eval
