from fieldrig_page.process import main

if __name__ == "__main__":
    main()
