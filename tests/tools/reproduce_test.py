"""`plenum reproduce`: text, JSON and page."""

import html
import json

from command import CommandTest, run


class Reproduce(CommandTest):
    def test_a_paper_that_is_none_is_refused_with_those_there_are(self):
        self.refused(2, "reproduce", "--paper", "6", says=["6 is none", "1 (Modeling and Identification of Pneumatic Actuators)"])
        self.refused(2, "reproduce", "--paper", "0", says=["0 is none"])
        self.refused(2, "reproduce", "--report", "nowhere/page.html", says=["nowhere", "no such folder"])

    def test_text_json_and_page_say_the_same_of_a_paper(self):
        text = self.done("reproduce", "--paper", "4", "--json", "papers.json", "--report", "papers.html")
        said = json.loads((self.folder / "papers.json").read_text())
        self.assertEqual((said["schema"], len(said["papers"])), ("plenum-reproduce/1", 1))
        paper = said["papers"][0]
        findings = [one for part in paper["parts"] for one in part["findings"]]
        self.assertGreater(len(findings), 10)
        page = html.unescape((self.folder / "papers.html").read_text())
        said_in_words = " ".join(text.split())
        for part in paper["parts"]:
            self.assertIn(" ".join(part["text"].split()), said_in_words)
        self.assertLessEqual(max(len(line) for line in text.split("\n") if line.startswith("  ") and line[2:3].strip()), 100)
        for one in findings:
            self.assertIn(one["quantity"], text)
            kept = one["expect"] != "near" and one["verdict"] == "reproduced"
            self.assertIn(f"{'within bound' if kept else 'difference %.5g' % one['difference']}: {one['verdict']}", text)
            self.assertIn(one["quantity"], page)
            self.assertEqual(one["verdict"] == "reproduced", agrees(one), one)
            self.assertTrue(one["verdict"] == "reproduced" or one["why"], one)
        counts = {verdict: sum(one["verdict"] == verdict for one in findings) for verdict in paper["verdicts"]}
        self.assertEqual(counts, paper["verdicts"])
        self.assertIn(f"paper 4: {counts['reproduced']} reproduced, {counts['differs']} differ, ", text)


def agrees(finding):
    """The verdict by a second route, from the numbers in the file."""
    if finding["ours"] is None or finding["paper"] is None:
        return False
    room = finding["tolerance"] + 1e-15 * max(abs(finding["ours"]), abs(finding["paper"]))
    above = finding["ours"] > finding["paper"] + room
    below = finding["ours"] < finding["paper"] - room
    return {"near": not above and not below, "at most": not above, "at least": not below}[finding["expect"]]


if __name__ == "__main__":
    run()
