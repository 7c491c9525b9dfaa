// Pages opened from the disk may start no worker, which the search is: an iframe does its work there.
// The theme's plugin `offline` would load such a script from a network.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      this.frame = Object.assign(document.createElement("iframe"), { hidden: true })
      document.body.append(this.frame)
      this.inside = this.frame.contentWindow
      this.heard = event => {
        if (event.source !== this.inside) return
        this.dispatchEvent(new MessageEvent("message", { data: event.data }))
        if (this.onmessage) this.onmessage(event)
      }
      addEventListener("message", this.heard)
      this.ready = new Promise(resolve => { this.frame.onload = resolve })
      const page = this.inside.document
      page.open()
      page.write(`<script>
        postMessage = data => parent.dispatchEvent(new MessageEvent("message", { data, source: window }))
        importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((done, failed) => {
          const script = Object.assign(document.createElement("script"), { src: url, onload: done, onerror: failed })
          document.body.append(script)
        })), Promise.resolve())
      <\/script><body><script src="${url}"><\/script>`)
      page.close()
    }
    postMessage(data) {
      this.ready.then(() => this.inside.dispatchEvent(new MessageEvent("message", { data })))
    }
    terminate() {
      this.frame.remove()
      removeEventListener("message", this.heard)
    }
  }
}
