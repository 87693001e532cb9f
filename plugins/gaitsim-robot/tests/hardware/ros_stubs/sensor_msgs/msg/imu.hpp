#pragma once
#include <array>
#include <geometry_msgs/msg/twist.hpp>
namespace sensor_msgs::msg {
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
struct Imu {
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  geometry_msgs::msg::Vector3 angular_velocity;
};
}  // namespace sensor_msgs::msg
