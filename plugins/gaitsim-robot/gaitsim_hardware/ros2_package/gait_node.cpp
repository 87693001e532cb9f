// @TITLE@. Written by gaitsim.
//
// Subscribes to `cmd_vel` (geometry_msgs/Twist: linear.x, linear.y and angular.z) and, if the
// reflexes need them, to `imu` (sensor_msgs/Imu with an orientation, mounted with x forward and z up),
// `load` (std_msgs/Float64MultiArray: force on each foot as a share of the weight, in the order of
// the legs @LEGS_TEXT@) and `joint_states`. Publishes the positions of the joints on `commands`
// (std_msgs/Float64MultiArray), in the order of config/controllers.yaml.
//
// Starts when it knows the joints' positions, and moves to the standing pose in RISE s. The robot
// stands without `cmd_vel` for COMMAND_TIMEOUT s, and without measurements for SENSOR_TIMEOUT s.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <geometry_msgs/msg/twist.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>

#include "gait.h"

namespace {

const double RISE = 3.0;             // s
const double COMMAND_TIMEOUT = 0.5;  // s
const double SENSOR_TIMEOUT = 0.2;   // s; the gait then stops after 0.2 s more
const double NOTHING = std::numeric_limits<double>::quiet_NaN();

const char *const JOINTS[GAIT_JOINTS] = {
@JOINTS@
};

double limited(double value, double most) { return std::clamp(value, -most, most); }

}  // namespace

class GaitNode : public rclcpp::Node {
 public:
  GaitNode() : Node("gait") {
    gait_init(&state_);
    for (int joint = 0; joint < GAIT_JOINTS; joint++) index_[JOINTS[joint]] = joint;
    publisher_ = create_publisher<std_msgs::msg::Float64MultiArray>("commands", 10);
    command_subscription_ = create_subscription<geometry_msgs::msg::Twist>(
        "cmd_vel", 10, [this](const geometry_msgs::msg::Twist &told) { obey(told); });
    joint_subscription_ = create_subscription<sensor_msgs::msg::JointState>(
        "joint_states", 10, [this](const sensor_msgs::msg::JointState &felt) { read(felt); });
    imu_subscription_ = create_subscription<sensor_msgs::msg::Imu>(
        "imu", rclcpp::SensorDataQoS(), [this](const sensor_msgs::msg::Imu &felt) { read(felt); });
    load_subscription_ = create_subscription<std_msgs::msg::Float64MultiArray>(
        "load", 10, [this](const std_msgs::msg::Float64MultiArray &felt) { read(felt); });
    timer_ = create_wall_timer(
        std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::duration<double>(GAIT_INTERVAL)),
        [this]() { step(); });
  }

 private:
  void obey(const geometry_msgs::msg::Twist &told) {
    command_.speed = limited(told.linear.x, GAIT_MAX_SPEED);
    command_.sideways = limited(told.linear.y, GAIT_MAX_SIDEWAYS);
    command_.turn = limited(told.angular.z, GAIT_MAX_TURN);
    commanded_ = now();
  }

  void read(const sensor_msgs::msg::JointState &felt) {
    const size_t count = std::min(felt.name.size(), felt.position.size());
    for (size_t i = 0; i < count; i++) {
      const auto found = index_.find(felt.name[i]);
      if (found == index_.end() || !std::isfinite(felt.position[i])) continue;
      senses_.joints[found->second] = felt.position[i];
      known_[found->second] = true;
    }
    joints_read_ = now();
  }

  void read(const sensor_msgs::msg::Imu &felt) {
    const double w = felt.orientation.w, x = felt.orientation.x;
    const double y = felt.orientation.y, z = felt.orientation.z;
    // A covariance of -1 means that the message has no orientation.
    if (felt.orientation_covariance[0] < 0 || !(w * w + x * x + y * y + z * z > 0.5)) {
      RCLCPP_ERROR_THROTTLE(get_logger(), *get_clock(), 5000, "the IMU reports no orientation");
      return;
    }
    const double yaw = std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    if (!oriented_) first_yaw_ = yaw;
    oriented_ = true;
    senses_.orientation[0] = std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
    senses_.orientation[1] = std::asin(limited(2 * (w * y - z * x), 1));
    senses_.orientation[2] = yaw - first_yaw_;
    senses_.rates[0] = felt.angular_velocity.x;
    senses_.rates[1] = felt.angular_velocity.y;
    senses_.rates[2] = felt.angular_velocity.z;
    imu_read_ = now();
  }

  void read(const std_msgs::msg::Float64MultiArray &felt) {
    if (felt.data.size() != GAIT_LEGS) {
      RCLCPP_ERROR_THROTTLE(get_logger(), *get_clock(), 5000, "load has %zu numbers, not %d",
                            felt.data.size(), GAIT_LEGS);
      return;
    }
    for (int leg = 0; leg < GAIT_LEGS; leg++) {
      senses_.load[leg] = felt.data[leg];
      senses_.contacts[leg] = felt.data[leg] > 0;
    }
    load_read_ = now();
  }

  bool old(const rclcpp::Time &time, double most) { return (now() - time).seconds() > most; }

  void step() {
    if (!std::all_of(known_.begin(), known_.end(), [](bool one) { return one; })) {
      RCLCPP_INFO_THROTTLE(get_logger(), *get_clock(), 5000, "waiting for all joint_states");
      return;
    }
    std_msgs::msg::Float64MultiArray message;
    message.data.resize(GAIT_JOINTS);
    if (risen_ < RISE) {
      if (risen_ == 0) std::copy_n(senses_.joints, GAIT_JOINTS, first_);
      risen_ += GAIT_INTERVAL;
      const double share = std::min(risen_ / RISE, 1.0);
      const double smooth = share * share * (3 - 2 * share);
      for (int joint = 0; joint < GAIT_JOINTS; joint++) {
        message.data[joint] = first_[joint] + smooth * (GAIT_STANDING[joint] - first_[joint]);
      }
    } else {
      gait_command command = {0, 0, 0, 0};
      if (!old(commanded_, COMMAND_TIMEOUT)) command = command_;
      gait_senses felt = senses_;
#if GAIT_NEEDS_ORIENTATION || GAIT_NEEDS_RATES
      if (old(imu_read_, SENSOR_TIMEOUT)) felt.orientation[0] = NOTHING;
#endif
#if GAIT_NEEDS_CONTACTS || GAIT_NEEDS_LOAD
      if (old(load_read_, SENSOR_TIMEOUT)) felt.load[0] = NOTHING;
#endif
#if GAIT_NEEDS_JOINTS
      if (old(joints_read_, SENSOR_TIMEOUT)) felt.joints[0] = NOTHING;
#endif
      gait_step(&state_, GAIT_INTERVAL, &felt, &command, message.data.data());
    }
    publisher_->publish(message);
  }

  gait_state state_{};
  gait_senses senses_{};
  gait_command command_{};
  std::map<std::string, int> index_;
  std::vector<bool> known_ = std::vector<bool>(GAIT_JOINTS, false);
  double first_[GAIT_JOINTS] = {};
  double risen_ = 0;  // s
  double first_yaw_ = 0;
  bool oriented_ = false;
  rclcpp::Time commanded_{0, 0, RCL_ROS_TIME}, imu_read_{0, 0, RCL_ROS_TIME};
  rclcpp::Time load_read_{0, 0, RCL_ROS_TIME}, joints_read_{0, 0, RCL_ROS_TIME};
  rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr publisher_;
  rclcpp::Subscription<geometry_msgs::msg::Twist>::SharedPtr command_subscription_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr joint_subscription_;
  rclcpp::Subscription<sensor_msgs::msg::Imu>::SharedPtr imu_subscription_;
  rclcpp::Subscription<std_msgs::msg::Float64MultiArray>::SharedPtr load_subscription_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int count, char **words) {
  rclcpp::init(count, words);
  rclcpp::spin(std::make_shared<GaitNode>());
  rclcpp::shutdown();
}
