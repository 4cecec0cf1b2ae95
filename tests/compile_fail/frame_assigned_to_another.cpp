// EXPECT: conversion from .*frame::Odom.* to .*frame::Map
#include <wayfare/core/frame.hpp>

namespace frame = wayfare::frame;

void assign(const wayfare::Transform2<frame::Odom, frame::Base>& T_odom_base) {
  wayfare::Transform2<frame::Odom, frame::Base> same = T_odom_base;
  (void)same;
#ifdef WAYFARE_MUST_FAIL
  wayfare::Transform2<frame::Map, frame::Base> other = T_odom_base;
  (void)other;
#endif
}
