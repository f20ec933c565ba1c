#include "tumble/recorder/testing/disk_vfs.hpp"

#include <sqlite3.h>

#include <atomic>
#include <filesystem>
#include <new>

#include "tumble/units/error.hpp"

namespace tumble::testing {

namespace {

/// An open file: SQLite allocates it, and behind it that of the system's VFS.
struct File {
  sqlite3_file base;
  DiskState* state;
  std::string* path;  ///< null for a temporary file
  bool names_folder;  ///< its next synchronisation is also that of its folder, as the system's VFS does it
};

File* file_of(sqlite3_file* file) { return reinterpret_cast<File*>(file); }
sqlite3_file* real(sqlite3_file* file) { return reinterpret_cast<sqlite3_file*>(file_of(file) + 1); }
const sqlite3_io_methods& methods(sqlite3_file* file) { return *real(file)->pMethods; }
DiskState& state_of(sqlite3_vfs* vfs) { return *static_cast<DiskState*>(vfs->pAppData); }
sqlite3_vfs* system_vfs() { return sqlite3_vfs_find("unix"); }

/// Notes what the system itself reports.
int noted(DiskState& state, int code) {
  if (code != SQLITE_OK && code != SQLITE_FULL) state.note_error();
  return code;
}

int code_of(Outcome outcome, int failure) { return outcome == Outcome::full ? SQLITE_FULL : failure; }

int close_file(sqlite3_file* file) {
  const int code = methods(file).xClose(real(file));
  delete file_of(file)->path;
  return code;
}

int read(sqlite3_file* file, void* bytes, int size, sqlite3_int64 offset) {
  return methods(file).xRead(real(file), bytes, size, offset);
}

int write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
  File& self = *file_of(file);
  if (self.path) {
    sqlite3_int64 length = 0;
    methods(file).xFileSize(real(file), &length);
    const Outcome outcome = self.state->write(*self.path, static_cast<std::uint64_t>(offset),
                                              {static_cast<const char*>(bytes), static_cast<std::size_t>(size)},
                                              static_cast<std::uint64_t>(length));
    if (outcome != Outcome::done) return code_of(outcome, SQLITE_IOERR_WRITE);
  }
  return noted(*self.state, methods(file).xWrite(real(file), bytes, size, offset));
}

int truncate_file(sqlite3_file* file, sqlite3_int64 length) {
  File& self = *file_of(file);
  if (self.path) {
    const Outcome outcome = self.state->truncate(*self.path, static_cast<std::uint64_t>(length));
    if (outcome != Outcome::done) return code_of(outcome, SQLITE_IOERR_TRUNCATE);
  }
  return noted(*self.state, methods(file).xTruncate(real(file), length));
}

int synchronise(sqlite3_file* file, int flags) {
  File& self = *file_of(file);
  if (self.path) {
    const Outcome outcome = self.state->synchronise(*self.path);
    if (outcome != Outcome::done) return SQLITE_IOERR_FSYNC;
  }
  if (!self.state->tested())
    if (const int code = noted(*self.state, methods(file).xSync(real(file), flags)); code != SQLITE_OK) return code;
  if (!self.path || !self.names_folder) return SQLITE_OK;
  self.names_folder = false;
  const Outcome outcome = self.state->synchronise_folder(std::filesystem::path(*self.path).parent_path().string());
  return outcome == Outcome::done ? SQLITE_OK : SQLITE_IOERR_DIR_FSYNC;
}

int file_size(sqlite3_file* file, sqlite3_int64* size) { return methods(file).xFileSize(real(file), size); }
int lock(sqlite3_file* file, int level) { return methods(file).xLock(real(file), level); }
int unlock(sqlite3_file* file, int level) { return methods(file).xUnlock(real(file), level); }
int check_lock(sqlite3_file* file, int* result) { return methods(file).xCheckReservedLock(real(file), result); }
int control(sqlite3_file* file, int code, void* argument) {
  return methods(file).xFileControl(real(file), code, argument);
}
int sector_size(sqlite3_file* file) { return methods(file).xSectorSize(real(file)); }
int characteristics(sqlite3_file* file) { return methods(file).xDeviceCharacteristics(real(file)); }

/// Version 1: without shared memory, because the store has one connection, which locks it alone.
const sqlite3_io_methods& own_methods() {
  static const sqlite3_io_methods methods{
      1,       close_file, read,       write,   truncate_file, synchronise,     file_size,
      lock,    unlock,     check_lock, control, sector_size,   characteristics, nullptr,
      nullptr, nullptr,    nullptr,    nullptr, nullptr};
  return methods;
}

int open_file(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  File& self = *file_of(file);
  self.base.pMethods = nullptr;
  self.state = &state_of(vfs);
  self.path = nullptr;
  self.names_folder = false;
  const bool creates = (flags & SQLITE_OPEN_CREATE) != 0 && name && !std::filesystem::exists(name);
  if (name && self.state->open(name, creates) != Outcome::done) return SQLITE_CANTOPEN;
  const int code = system_vfs()->xOpen(system_vfs(), name, real(file), flags, out_flags);
  if (code != SQLITE_OK) {
    if (real(file)->pMethods) real(file)->pMethods->xClose(real(file));
    return code;
  }
  if (name) self.path = new (std::nothrow) std::string(name);
  self.names_folder = creates && (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL)) != 0;
  self.base.pMethods = &own_methods();
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs* vfs, const char* name, int synchronise_folder) {
  DiskState& state = state_of(vfs);
  if (const Outcome outcome = state.remove(name); outcome != Outcome::done)
    return code_of(outcome, SQLITE_IOERR_DELETE);
  const int code = system_vfs()->xDelete(system_vfs(), name, synchronise_folder);
  if (code != SQLITE_OK) return code == SQLITE_IOERR_DELETE_NOENT ? code : noted(state, code);
  if (!synchronise_folder) return SQLITE_OK;
  const Outcome outcome = state.synchronise_folder(std::filesystem::path(name).parent_path().string());
  return outcome == Outcome::done ? SQLITE_OK : SQLITE_IOERR_DIR_FSYNC;
}

}  // namespace

void DiskVfs::Unregister::operator()(sqlite3_vfs* vfs) const {
  sqlite3_vfs_unregister(vfs);
  delete vfs;
}

DiskVfs::~DiskVfs() = default;

DiskVfs::DiskVfs(DiskState& state) {
  static std::atomic<int> number = 0;
  name_ = "tumble-disk-" + std::to_string(number++);
  sqlite3_initialize();
  const sqlite3_vfs* const system = system_vfs();
  if (!system) throw Error(Error::Kind::internal, "SQLite has no VFS 'unix'");
  vfs_.reset(new sqlite3_vfs(*system));  // what is not replaced below stays that of the system
  vfs_->pNext = nullptr;
  vfs_->szOsFile = static_cast<int>(sizeof(File)) + system->szOsFile;
  vfs_->zName = name_.c_str();
  vfs_->pAppData = &state;
  vfs_->xOpen = open_file;
  vfs_->xDelete = delete_file;
  if (sqlite3_vfs_register(vfs_.get(), 0) != SQLITE_OK) throw Error(Error::Kind::internal, "SQLite refuses a VFS");
}

}  // namespace tumble::testing
