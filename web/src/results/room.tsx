// The list of results, one of them, or several beside each other.
import "./results.css";
import { ComparisonPage } from "./comparison";
import { ResultPage } from "./result";
import { ResultsPage } from "./list";
import { files } from "./view";

export function ResultsRoom() {
  const [first, second] = files.value;
  if (first === undefined) return <ResultsPage />;
  return second === undefined ? <ResultPage key={first} file={first} /> : <ComparisonPage key={files.value.join("\n")} files={files.value} />;
}
