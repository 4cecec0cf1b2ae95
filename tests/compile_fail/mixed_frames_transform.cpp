// EXPECT: inner frames differ; T_a_b \* T_b_c needs the same b on both sides
#include <wayfare/core/frame.hpp>

namespace frame = wayfare::frame;

void chain(const wayfare::Transform2<frame::Map, frame::Odom>& T_map_odom,
           const wayfare::Transform2<frame::Odom, frame::Base>& T_odom_base) {
  (void)(T_map_odom * T_odom_base);
#ifdef WAYFARE_MUST_FAIL
  (void)(T_odom_base * T_map_odom);
#endif
}
