// EXPECT: the point is not in this transform's source frame
#include <wayfare/core/frame.hpp>

namespace frame = wayfare::frame;

void move(const wayfare::Transform3<frame::Map, frame::Base>& T_map_base,
          const wayfare::Point3<frame::Base>& p_base, const wayfare::Point3<frame::Map>& p_map) {
  (void)(T_map_base * p_base);
  (void)p_map;
#ifdef WAYFARE_MUST_FAIL
  (void)(T_map_base * p_map);
#endif
}
