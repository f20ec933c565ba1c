// The list of recordings, or one of them.
import { RecordingPage } from "./recording";
import { RecordingsPage } from "./recordings";
import { file } from "./view";

export function RecordingsRoom() {
  return file.value === null ? <RecordingsPage /> : <RecordingPage key={file.value} file={file.value} />;
}
