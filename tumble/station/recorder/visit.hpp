#pragma once

#include <functional>
#include <optional>
#include <string>

#include "tumble/station/recorder/store_file.hpp"
#include "tumble/station/recorder_read.hpp"

namespace tumble::recorder {

/// The file of the store of a run, which is its folder or that file. Throws Error::bad_file.
std::string path_of_store(const std::string& run);
/// Throws Error::bad_file.
StoreFile open_store(const std::string& path, Disk& disk);
[[noreturn]] void refuse_to_read(const std::string& path, const Refusal& refusal);

/// Links, streams and facts of a store. Throws Refusal.
StoreContent describe(const StoreFile& store);
/// Hands out its items in order, all or those of one kind, and counts them in `content`. Throws Refusal.
void visit(const StoreFile& store, StoreContent& content, const std::function<void(const StoreItem&)>& visitor,
           std::optional<StoreItem::Kind> only = {});

}  // namespace tumble::recorder
