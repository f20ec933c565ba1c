#include "tumble/exchange/testing/file_numbers.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <charconv>
#include <cmath>

namespace tumble::testing {
namespace {

bool begins_number(const std::string& text, std::size_t at) {
  const auto digit = [&](std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i]));
  };
  if (text[at] == '-' || text[at] == '+') ++at;
  return digit(at) || (at < text.size() && text[at] == '.' && digit(at + 1));
}

}  // namespace

std::string without_comments(const std::string& text, std::string_view mark) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    out += line.substr(0, line.find(mark)) + "\n";
    begin = end + 1;
  }
  return out;
}

std::vector<double> numbers_after(const std::string& text, std::string_view key, std::size_t count) {
  std::vector<double> numbers;
  std::size_t at = text.find(key);
  if (at == std::string::npos) {
    ADD_FAILURE() << "no " << key;
    return std::vector<double>(count, std::nan(""));
  }
  at += key.size();
  while (at < text.size() && numbers.size() < count) {
    if (begins_number(text, at)) {
      double value = 0.0;
      if (text[at] == '+') ++at;
      const auto [end, problem] = std::from_chars(text.data() + at, text.data() + text.size(), value);
      EXPECT_EQ(problem, std::errc{});
      numbers.push_back(value);
      at = static_cast<std::size_t>(end - text.data());
    } else if (std::isalpha(static_cast<unsigned char>(text[at]))) {
      ADD_FAILURE() << "a word follows " << key << ": " << text.substr(at, 20);
      break;
    } else {
      ++at;
    }
  }
  numbers.resize(count, std::nan(""));
  return numbers;
}

double number_after(const std::string& text, std::string_view key) { return numbers_after(text, key, 1)[0]; }

Vector3 vector_after(const std::string& text, std::string_view key) {
  const auto n = numbers_after(text, key, 3);
  return {n[0], n[1], n[2]};
}

Matrix3 matrix_after(const std::string& text, std::string_view key) {
  const auto n = numbers_after(text, key, 9);
  return {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}};
}

}  // namespace tumble::testing
