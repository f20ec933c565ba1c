#pragma once

#include <functional>

#include "tumble/formats/topics/topic.hpp"

namespace tumble::topics {

/// Receives each message of a topic: its index in Log::topics, and where the message begins.
using TakeMessage = std::function<void(std::size_t topic, const char* message)>;
/// Goes through a file and hands out the messages of the topics that are read, each with all bytes that its columns
/// need.
using Messages = std::function<void(const TakeMessage&, const Progress&)>;

/// Samples [1] of a message at most.
std::size_t most_samples(const Layout& layout);

/// Lets `log`, whose topics and columns are final, hand out the samples of messages that all have the layout of their
/// topic.
void play_messages(Messages messages, Log& log);

}  // namespace tumble::topics
