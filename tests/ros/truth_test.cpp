// True poses in a recording: topics of every type, transforms, and what is wrong with them.

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "io/support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const LogTime kFirstPose = LogTime::from_seconds(1'600'000'000.0);

LogTime pose_time(int i) { return kFirstPose + from_seconds(0.1 * i); }
SE2d true_place(int i) { return {1.0 * i, 2.0, Angle::degrees(10.0 * i)}; }

class TruthInARecording : public ::testing::Test {
 protected:
  TruthInARecording() : writer_(std::move(*ros::RecordingWriter::create(path_))) {
    for (int i = 0; i < 3; ++i) {
      const LaserScan scan{pose_time(i), Angle(), Angle::degrees(1.0), 0.1F, 9.0F, {1.0F, 2.0F}};
      write("/scan", i, ros::message_of(scan, "base_link"));
    }
  }
  template <class M>
  void write(const std::string& topic, int i, const M& message) {
    ASSERT_TRUE(writer_.write(topic, pose_time(i), message));
  }
  void close() { EXPECT_TRUE(writer_.close()); }
  Result<ros::TruthRun> read(const ros::TopicNames& names = {}) {
    return ros::read_truth(*ros::RecordingFile::open(path_), names);
  }
  void expect_places(const ros::TopicNames& names) {
    const auto alone = read(names);
    ASSERT_TRUE(alone) << alone.error().to_string();
    const auto robot = ros::read_robot(*ros::RecordingFile::open(path_), names);
    ASSERT_TRUE(robot) << robot.error().to_string();
    for (const Trajectory& truth : {alone->truth, robot->recording.truth}) {
      ASSERT_EQ(truth.size(), 3U);
      for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(truth[static_cast<std::size_t>(i)].time, pose_time(i));
        EXPECT_LT(truth[static_cast<std::size_t>(i)].T_map_base.raw().minus(true_place(i)).norm(),
                  1e-12);
      }
    }
  }

  testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "a.bag";
  ros::RecordingWriter writer_;
};

TEST_F(TruthInARecording, MayBePosesWithCovariance) {
  for (int i = 0; i < 3; ++i)
    write("/vicon", i,
          ros::PoseWithCovarianceStamped{ros::header_of(pose_time(i), "world"),
                                         {ros::pose_of(true_place(i))}});
  close();
  ros::TopicNames names;
  names.truth = "/vicon";
  expect_places(names);
  EXPECT_THAT(read()->truth, IsEmpty()) << "only /truth is read without a name";
}

TEST_F(TruthInARecording, MayBePosesOrOdometry) {
  for (int i = 0; i < 3; ++i) {
    const StampedPose pose{pose_time(i), Transform2<frame::Map, frame::Base>(true_place(i))};
    write("/truth", i, ros::message_of(pose, "world"));
    const OdometrySample sample{pose_time(i), Transform2<frame::Odom, frame::Base>(true_place(i))};
    write("/state", i, ros::message_of(sample, "world", "base_link"));
  }
  close();
  expect_places({});
  ros::TopicNames names;
  names.truth = "/state";
  expect_places(names);
}

TEST_F(TruthInARecording, MayBeATransform) {
  for (int i = 0; i < 3; ++i)
    write("/tf", i,
          ros::TfMessage{{ros::transform_of(SE2d(), pose_time(i), "odom", "base_link"),
                          ros::transform_of(true_place(i), pose_time(i), "/world", "/tracker")}});
  close();
  ros::TopicNames names;
  names.truth_frames = {"world", "tracker"};
  expect_places(names);
  const auto robot = ros::read_robot(*ros::RecordingFile::open(path_), names);
  EXPECT_EQ(robot->recording.odometry.size(), 3U) << "the odometry by transforms is still read";
  names.truth_frames = {"world", "base_link"};
  EXPECT_THAT(read(names).error().to_string(),
              HasSubstr("has no transform from 'world' to 'base_link'"));
  EXPECT_FALSE(ros::read_robot(*ros::RecordingFile::open(path_), names));
  names.truth_frames = {"world"};
  EXPECT_THAT(read(names).error().to_string(), HasSubstr("two frames"));
}

/// The robot's place in the world as a tracker on the robot, seen by cameras that stand in the
/// world, measures it; the cameras' poses come at half the rate.
TEST_F(TruthInARecording, MayBeAChainOfTransforms) {
  const SE2d T_world_cameras(3.0, -1.0, Angle::degrees(40.0));
  const SE2d T_tracker_base(-0.1, 0.2, Angle::degrees(90.0));
  write("/tf_static", 0,
        ros::TfMessage{
            {ros::transform_of(T_tracker_base.inverse(), pose_time(0), "base_link", "tracker")}});
  for (int i = 0; i < 3; ++i) {
    if (i != 1)
      write("/tf", i,
            ros::TfMessage{{ros::transform_of(T_world_cameras, pose_time(i), "world", "cameras")}});
    write("/tf", i,
          ros::TfMessage{{ros::transform_of(T_world_cameras.inverse() * true_place(i), pose_time(i),
                                            "/cameras", "/base_link")}});
  }
  close();
  ros::TopicNames names;
  names.truth_frames = {"world", "base_link"};
  expect_places(names);
  names.truth_frames = {"world", "tracker"};
  const auto tracker = read(names);
  ASSERT_TRUE(tracker) << tracker.error().to_string();
  ASSERT_EQ(tracker->truth.size(), 3U);
  for (int i = 0; i < 3; ++i)
    EXPECT_LT(tracker->truth[static_cast<std::size_t>(i)]
                  .T_map_base.raw()
                  .minus(true_place(i) * T_tracker_base.inverse())
                  .norm(),
              1e-12);
  names.truth_frames = {"tracker", "world"};
  EXPECT_LT(read(names)
                ->truth[2]
                .T_map_base.raw()
                .minus((true_place(2) * T_tracker_base.inverse()).inverse())
                .norm(),
            1e-12);
  names.truth_frames = {"base_link", "tracker"};
  EXPECT_EQ(read(names)->truth.size(), 1U) << "one transform, directly";
}

TEST_F(TruthInARecording, ABrokenChainIsNamed) {
  for (int i = 0; i < 3; ++i)
    write("/tf", i,
          ros::TfMessage{{ros::transform_of(true_place(i), pose_time(i), "cameras", "tracker"),
                          ros::transform_of(SE2d(), pose_time(i), "tracker", "base_link"),
                          ros::transform_of(SE2d(), pose_time(i + 100), "world", "tent")}});
  // Never at a time at which the tracker was seen.
  for (const int i : {100, 101})
    write("/tf", i,
          ros::TfMessage{{ros::transform_of(SE2d(), pose_time(i), "tent", "table"),
                          ros::transform_of(SE2d(), pose_time(i), "tracker", "late")}});
  write("/tf_static", 0,
        ros::TfMessage{{ros::transform_of(SE2d(), pose_time(0), "tent", "pole"),
                        ros::transform_of(SE2d(), pose_time(0), "pole", "flag")}});
  close();
  ros::TopicNames names;
  const auto error = [&](const char* base, const char* frame) {
    names.truth_frames = {base, frame};
    const auto result = read(names);
    return result ? "no error" : result.error().to_string();
  };
  EXPECT_THAT(
      error("world", "base_link"),
      HasSubstr("no transform from 'world' to 'base_link': the chain is broken, 'base_link' "
                "leads up to 'cameras', 'world' has no parent"));
  EXPECT_THAT(error("world", "nothing"), HasSubstr("'nothing' has no parent"));
  EXPECT_THAT(error("cameras", "late"),
              HasSubstr("no time at which all transforms from 'cameras' to 'late' are known: "
                        "'tracker' -> 'late' is from 1600000010.0"));
  EXPECT_THAT(error("tent", "flag"), HasSubstr("only constant transforms from 'tent' to 'flag'"));
}

TEST_F(TruthInARecording, ALoopOfFramesIsNoChain) {
  for (int i = 0; i < 3; ++i)
    write("/tf", i,
          ros::TfMessage{{ros::transform_of(SE2d(), pose_time(i), "a", "b"),
                          ros::transform_of(SE2d(), pose_time(i), "b", "a")}});
  close();
  ros::TopicNames names;
  names.truth_frames = {"world", "a"};
  EXPECT_THAT(read(names).error().to_string(), HasSubstr("the chain is broken"));
}

TEST_F(TruthInARecording, HasOnePoseForATime) {
  for (const int i : {2, 0, 1, 1}) {
    const StampedPose pose{pose_time(i), Transform2<frame::Map, frame::Base>(true_place(i))};
    write("/truth", i, ros::message_of(pose, "world"));
  }
  close();
  expect_places({});
  const auto read_again = read();
  ASSERT_EQ(read_again->problems.count(), 1U);
  EXPECT_THAT(read_again->problems.first()[0].to_string(),
              HasSubstr("1 true poses have the time of another one"));
}

TEST_F(TruthInARecording, ANamedTopicMustExist) {
  close();
  ros::TopicNames names;
  names.truth = "/vicon";
  EXPECT_THAT(read(names).error().to_string(), HasSubstr("has no topic /vicon"));
  EXPECT_THAT(read()->truth, IsEmpty());
}

}  // namespace
}  // namespace wayfare
