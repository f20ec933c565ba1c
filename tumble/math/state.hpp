#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {

/// The state of an estimator as bytes, for another process of the same program. A type that has one lists its members
/// once, for both directions:
///
///   template <class State> void pass(State& state) { state(samples_, scales_); }
///
/// A plain struct without that function goes as the bytes that it is.
class StateWriter {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (write(values), ...);
  }
  std::string take() { return std::move(bytes_); }

 private:
  template <class T>
  void write(T& value) {
    if constexpr (std::is_same_v<T, long double>) {
      const auto high = static_cast<double>(value);
      raw(high);
      raw(static_cast<double>(value - static_cast<long double>(high)));
    } else if constexpr (requires { value.pass(*this); }) {
      value.pass(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      raw(value);
    }
  }
  template <class T, std::size_t size>
  void write(T (&values)[size]) {
    for (T& value : values) write(value);
  }
  template <class T, std::size_t size>
  void write(std::array<T, size>& values) {
    for (T& value : values) write(value);
  }
  template <class T>
  void write(std::vector<T>& values) {
    several(values);
  }
  template <class T>
  void write(std::deque<T>& values) {
    several(values);
  }
  void write(std::string& text) {
    raw(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  template <class Several>
  void several(Several& values) {
    raw(static_cast<std::uint64_t>(values.size()));
    for (auto& value : values) write(value);
  }
  template <class T>
  void raw(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }

  std::string bytes_;
};

/// Reads what a StateWriter wrote. Throws Error::bad_file where the bytes end early.
class StateReader {
 public:
  explicit StateReader(std::string_view bytes) : bytes_(bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (read(values), ...);
  }
  bool ended() const { return bytes_.empty(); }

 private:
  template <class T>
  void read(T& value) {
    if constexpr (std::is_same_v<T, long double>) {
      double high = 0.0, low = 0.0;
      raw(high);
      raw(low);
      value = static_cast<long double>(high) + static_cast<long double>(low);
    } else if constexpr (requires { value.pass(*this); }) {
      value.pass(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      raw(value);
    }
  }
  template <class T, std::size_t size>
  void read(T (&values)[size]) {
    for (T& value : values) read(value);
  }
  template <class T, std::size_t size>
  void read(std::array<T, size>& values) {
    for (T& value : values) read(value);
  }
  template <class T>
  void read(std::vector<T>& values) {
    several(values);
  }
  template <class T>
  void read(std::deque<T>& values) {
    several(values);
  }
  void read(std::string& text) {
    const std::size_t size = count();
    text.assign(bytes_.substr(0, size));
    bytes_.remove_prefix(size);
  }
  template <class Several>
  void several(Several& values) {
    values.clear();
    for (std::size_t left = count(); left > 0; --left) read(values.emplace_back());
  }
  /// No element takes less than a byte: a number that is damaged asks for no more than there is.
  std::size_t count() {
    std::uint64_t size = 0;
    raw(size);
    require(size);
    return static_cast<std::size_t>(size);
  }
  template <class T>
  void raw(T& value) {
    require(sizeof value);
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_.remove_prefix(sizeof value);
  }
  void require(std::uint64_t size) const {
    if (size > bytes_.size()) throw Error(Error::Kind::bad_file, "the state of an estimator ends early");
  }

  std::string_view bytes_;
};

}  // namespace tumble
