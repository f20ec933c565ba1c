#include "tumble/methods/accelerometer_four_position/polynomial.hpp"

#include <cmath>

namespace tumble::accelerometer_four_position {

double celsius(double temperature) { return temperature - 273.15; }

std::vector<double> powers(double temperature, std::size_t count) {
  std::vector<double> out;
  for (std::size_t j = 0; j < count; ++j) out.push_back(std::pow(celsius(temperature), static_cast<double>(j)));
  return out;
}

double at_temperature(const std::vector<double>& parameters, const Polynomial& polynomial, double temperature) {
  double sum = 0.0;
  for (std::size_t j = polynomial.count; j-- > 0;) sum = sum * celsius(temperature) + parameters[polynomial.first + j];
  return sum;
}

}  // namespace tumble::accelerometer_four_position
