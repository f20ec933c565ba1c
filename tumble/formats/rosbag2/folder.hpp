#pragma once

#include <string>
#include <vector>

namespace tumble::rosbag2 {

/// Whether a folder is a ROS 2 bag: metadata.yaml, and files of messages beside it.
bool is_folder_of_bag(const std::string& path);

/// The files of messages in a folder, in the order in which they were recorded: bag_2.db3 before bag_10.db3.
/// Throws Error::bad_file where the folder has none, where they are of two kinds, or where one is packed as a whole.
std::vector<std::string> files_of_bag(const std::string& folder);

}  // namespace tumble::rosbag2
