// The parts of rclcpp that the node uses. `spin` plays a script from standard input, one event a line:
//   step            advance by a period and run the timer; prints the published positions
//   joints NAME X … joint_states
//   twist X Y TURN  cmd_vel
//   imu W X Y Z     imu with this orientation
#pragma once
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <geometry_msgs/msg/twist.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>

#define RCLCPP_INFO_THROTTLE(...) (void)0
#define RCLCPP_ERROR_THROTTLE(...) (void)0
enum { RCL_ROS_TIME };

namespace rclcpp {

struct Duration {
  double s;
  double seconds() const { return s; }
};
struct Time {
  double s;
  Time(double given) : s(given) {}
  Time(int32_t given, uint32_t, int) : s(given) {}
  Duration operator-(const Time &other) const { return {s - other.s}; }
};
struct SensorDataQoS {};

template <class Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  static inline std::function<void(const Message &)> callback;
};
template <class Message>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  void publish(const Message &message) {
    for (double value : message.data) std::printf("%.17g ", value);
    std::printf("\n");
  }
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  static inline std::function<void()> callback;
  static inline double interval = 0;
};
inline double seconds = 1000;

class Node {
 public:
  explicit Node(const std::string &) {}
  Time now() { return Time(seconds); }
  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string &, int) {
    return std::make_shared<Publisher<Message>>();
  }
  template <class Message, class Quality, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(
      const std::string &, Quality, Callback callback) {
    Subscription<Message>::callback = callback;
    return std::make_shared<Subscription<Message>>();
  }
  TimerBase::SharedPtr create_wall_timer(std::chrono::nanoseconds time, std::function<void()> call) {
    TimerBase::callback = call;
    TimerBase::interval = static_cast<double>(time.count()) * 1e-9;
    return std::make_shared<TimerBase>();
  }
};

inline void init(int, char **) {}
inline void shutdown() {}
inline void spin(std::shared_ptr<Node>) {
  std::string line, word;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    words >> word;
    if (word == "step") {
      seconds += TimerBase::interval;
      TimerBase::callback();
    } else if (word == "joints") {
      sensor_msgs::msg::JointState felt;
      double position;
      while (words >> word >> position) {
        felt.name.push_back(word);
        felt.position.push_back(position);
      }
      Subscription<sensor_msgs::msg::JointState>::callback(felt);
    } else if (word == "twist") {
      geometry_msgs::msg::Twist told;
      words >> told.linear.x >> told.linear.y >> told.angular.z;
      Subscription<geometry_msgs::msg::Twist>::callback(told);
    } else if (word == "imu") {
      sensor_msgs::msg::Imu felt;
      auto &turn = felt.orientation;
      words >> turn.w >> turn.x >> turn.y >> turn.z;
      Subscription<sensor_msgs::msg::Imu>::callback(felt);
    }
  }
}

}  // namespace rclcpp
