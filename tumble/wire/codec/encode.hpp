#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/wire/frames.hpp"

namespace tumble::codec {

/// The bits of `raw` [1] as the number holds it; nothing where it does not fit.
std::optional<std::uint64_t> bits_for(const FrameNumber& number, double raw);

/// The number [1] beside value/factor that gives exactly this value [SI].
double raw_of(const FrameField& field, double value);

/// The field that carries each channel of the content: the first one that can.
std::vector<const FrameField*> chosen_fields(const FrameLayout& layout, const FrameContent& content);

/// A number [1] as the format says.
std::string written(const FrameFormat& format, double value);

/// A line of text with this content, as encode_frame. Throws Error::bad_input.
std::string encode_line(const FrameCodec& codec, const FrameContent& content, std::string_view base);

}  // namespace tumble::codec
