// EXPECT: a stance statistic is a value with a const member
#include <wayfare/pedestrian/foot_tracker.hpp>

struct Rate {
#ifdef WAYFARE_MUST_FAIL
  double operator()(const wayfare::ImuSample& s) const { return s.angular_rate_radps.norm(); }
#else
  double operator()(const wayfare::StanceWindow& window) const {
    return (*window.begin()).angular_rate_radps.norm();
  }
#endif
};

wayfare::BasicFootTracker<Rate> tracker(wayfare::FootParameters{}, Rate{});
